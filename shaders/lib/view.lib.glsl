// Converts scene-linear light to display values. The function `view_transform` of the view is appended to the shader
// that includes this file. It is written by OpenColorIO, or is that of lib/srgb_view.lib.glsl.

#include "lib/finite.lib.glsl"  // is_nan

#define LIGHT_MAX 65504.0  // the largest half float; infinity would become NaN in the transform

uniform float exposure_scale;  // factor on the light: 2^stops
uniform float inverse_gamma;   // exponent of the display values; 1 leaves them as they are

vec4 view_transform(vec4 light);

// Light without NaN and infinity: NaN becomes 0.
vec3 finite(vec3 light) {
    return mix(clamp(light, -LIGHT_MAX, LIGHT_MAX), vec3(0.0), is_nan(light));
}

// The display values of scene-linear rgb. The condition is not of the uniform alone, for which lavapipe of Mesa 22 would
// build the program anew for each run and never free it.
vec3 to_display(vec3 light) {
    vec3 shown = view_transform(vec4(exposure_scale * finite(light), 1.0)).rgb;
    if (shown == vec3(0.0) || inverse_gamma == 1.0) return shown;
    return sign(shown) * pow(abs(shown), vec3(inverse_gamma));
}

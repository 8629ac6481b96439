// Scene-linear light to display values. The view's own function is appended to the shader that
// includes this: OpenColorIO writes it.

#define LIGHT_MAX 65504.0  // the largest half float; infinity would become NaN in the transform

uniform float exposure_scale;  // 2^stops
uniform float inverse_gamma;   // 1 leaves the display values alone

vec4 view_transform(vec4 light);

vec3 finite(vec3 light) {
    return mix(clamp(light, -LIGHT_MAX, LIGHT_MAX), vec3(0.0), isnan(light));
}

vec3 to_display(vec3 light) {
    vec3 shown = view_transform(vec4(exposure_scale * finite(light), 1.0)).rgb;
    if (inverse_gamma == 1.0) return shown;
    return sign(shown) * pow(abs(shown), vec3(inverse_gamma));
}

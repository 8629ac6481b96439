// Draws a quad around each highlight's disc.

#include "lib/aperture.lib.glsl"

in vec4 in_place;  // centre x, y in pixels; signed coc; half the width of the rim's ramp
in vec4 in_light;  // rgb of a pixel wholly inside

uniform vec2 picture_size;

flat out vec4 place;
flat out vec3 light;

void main() {
    place = in_place;
    light = in_light.rgb;
    vec2 corner = vec2(gl_VertexID % 2, gl_VertexID / 2) * 2.0 - 1.0;
    vec2 reach = aperture_reach(0.5 * in_place.z, in_place.w) + 1.0;
    vec2 at = in_place.xy + corner * reach;
    gl_Position = vec4(at / picture_size * 2.0 - 1.0, 0.0, 1.0);
}

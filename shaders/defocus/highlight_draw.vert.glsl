// Draws a quad around the disc of each highlight that is not wholly hidden: of the large discs with LARGE, else of the
// others. (coc: signed circle of confusion, diameter in pixels, negative in front of the focus.)
//
// Inputs
//   in_disc, in_light, in_nodes   the highlight: a Sprite of lib/highlights.lib.glsl
// Outputs
//   disc, light, nodes            the same

#include "lib/aperture.lib.glsl"  // aperture_reach
#include "lib/highlights.lib.glsl"  // NOT_HIDDEN, LARGE_DISC

in vec4 in_disc;   // center x, y in pixels; signed coc; half the width of the rim's ramp
in vec4 in_light;  // rgb of a pixel wholly inside; a least signed coc that a ray may meet
in vec4 in_nodes;

uniform vec2 picture_size;

flat out vec4 disc;
flat out vec4 light;
flat out vec4 nodes;

#define OUTSIDE 2.0  // outside the picture, where nothing is drawn

void main() {
    disc = in_disc;
    light = in_light;
    nodes = in_nodes;
    vec2 corner = vec2(gl_VertexID % 2, gl_VertexID / 2) * 2.0 - 1.0;
    vec2 at = in_disc.xy + corner * (aperture_reach(0.5 * in_disc.z, in_disc.w) + 1.0);
#ifdef LARGE
    bool is_drawn = in_nodes.z == LARGE_DISC;
#else
    bool is_drawn = in_nodes.z >= NOT_HIDDEN;
#endif
    gl_Position = vec4(is_drawn ? at / picture_size * 2.0 - 1.0 : vec2(OUTSIDE), 0.0, 1.0);
}

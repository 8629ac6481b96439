// Puts highlights that are not drawn back into the light to diffuse: in the whole picture if there
// are too many, or in blocks of bright surfaces. If all are drawn, it runs on no workgroups.
//
// Inputs
//   high_tx, lit_buf  rgb of the removed light, a signed coc (highlight_split.comp.glsl)
//   plan, tally_buf   highlight_plan.comp.glsl: which highlights are drawn
// Output
//   low_img    the light to diffuse, read and written
//   low_fragment_buf  with LISTS: the fragments with their light restored

#ifdef LISTS
#include "lib/fragment_list.lib.glsl"
layout(std430) writeonly buffer low_fragment_block { uint low_fragment_buf[]; };
uniform sampler2D coc_tx;

// Restores the list of a pixel; returns true if the pixel's highlight was taken from the list.
bool restore_list(ivec2 at, float high_coc) {
    List list = list_at(at);
    for (uint i = WORDS * list.first; i < WORDS * list.end; ++i) low_fragment_buf[i] = fragment_buf[i];
    return list.has_front || high_coc != texelFetch(coc_tx, at, 0).r;
}
#endif

#include "lib/highlights.lib.glsl"
#include "lib/lit_bits.lib.glsl"

layout(local_size_x = PIXEL_GROUP, local_size_y = PIXEL_GROUP) in;

uniform sampler2D high_tx;
layout(rgba32f) uniform image2D low_img;
layout(std430) readonly buffer tally_block { uint tally_buf[]; };
layout(std430) readonly buffer plan_block { Plan plan; };

bool is_drawn(ivec2 at) {
    if (plan.level == uint(HIGHLIGHT_LEVELS)) return false;
    ivec2 blocks = (textureSize(high_tx, 0) + HIGHLIGHT_BLOCK - 1) / HIGHLIGHT_BLOCK;
    return tally_buf[tally_of(int(plan.level), at / HIGHLIGHT_BLOCK, blocks)] > 0u;
}

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    ivec2 size = textureSize(high_tx, 0);
    if (any(greaterThanEqual(at, size)) || is_drawn(at)) return;
    vec4 high = texelFetch(high_tx, at, 0);
#ifdef LISTS
    if (restore_list(at, high.a)) return;
#endif
    if (is_lit(at, size)) imageStore(low_img, at, imageLoad(low_img, at) + vec4(high.rgb, 0.0));
}

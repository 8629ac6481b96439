// Puts highlights that are not drawn as discs back into the light that is diffused: in the whole picture if there are
// too many of them, or in blocks that belong to bright surfaces. If all are drawn, the pass runs on no workgroups.
//
// Words (lib/highlights.lib.glsl): a sprite is a disc that is drawn for one or several highlights of similar coc; a
// higher level merges more of them; the plan says which level is drawn.
//
// Inputs
//   highlight_tx, lit_buf   rgb removed light, a its signed coc (circle of confusion, diameter in pixels), of the
//                      pixels whose bit is set in lit_buf (highlight_split.comp.glsl)
//   plan               highlight_plan.comp.glsl: the level that is drawn
//   tally_buf          highlight_sprites.comp.glsl: number of sprites of each block; a block with none is not drawn
// In and out
//   diffuse_img           rgb light to diffuse, with the restored highlights after the pass; a is kept
// Output
//   diffuse_fragment_buf  with LISTS: the fragments, with their light restored

#ifdef LISTS
#include "lib/fragment_list.lib.glsl"  // List, list_at, fragment_buf, WORDS
layout(std430) writeonly buffer diffuse_fragment_block { uint diffuse_fragment_buf[]; };
uniform sampler2D coc_tx;

// Restores the list of a pixel. Returns true if the pixel's highlight was taken from the list, and so need not be added
// to diffuse_img: the visible surface is in the list, or the highlight has another coc than the visible surface.
bool restore_list(ivec2 at, float highlight_coc) {
    List list = list_at(at);
    for (uint i = WORDS * list.first; i < WORDS * list.end; ++i) diffuse_fragment_buf[i] = fragment_buf[i];
    return list.has_front || highlight_coc != texelFetch(coc_tx, at, 0).r;
}
#endif

#include "lib/highlights.lib.glsl"  // Plan, tally_index
#include "lib/lit_bits.lib.glsl"  // is_lit

layout(local_size_x = PIXEL_GROUP, local_size_y = PIXEL_GROUP) in;

uniform sampler2D highlight_tx;
layout(rgba32f) uniform image2D diffuse_img;
layout(std430) readonly buffer tally_block { uint tally_buf[]; };
layout(std430) readonly buffer plan_block { Plan plan; };

// True if the highlight of a pixel is drawn as a disc.
bool is_drawn(ivec2 at) {
    if (plan.level == uint(HIGHLIGHT_LEVELS)) return false;
    ivec2 blocks = (textureSize(highlight_tx, 0) + HIGHLIGHT_BLOCK - 1) / HIGHLIGHT_BLOCK;
    return tally_buf[tally_index(int(plan.level), at / HIGHLIGHT_BLOCK, blocks)] > 0u;
}

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    ivec2 size = textureSize(highlight_tx, 0);
    if (any(greaterThanEqual(at, size)) || is_drawn(at)) return;
    vec4 highlight = texelFetch(highlight_tx, at, 0);
#ifdef LISTS
    if (restore_list(at, highlight.a)) return;
#endif
    if (is_lit(at, size)) imageStore(diffuse_img, at, imageLoad(diffuse_img, at) + vec4(highlight.rgb, 0.0));
}

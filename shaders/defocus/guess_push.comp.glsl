// Fills the unknown texels of a level of the pyramid (guess_pull.comp.glsl) from the next coarser
// level, which has none.
//
// Inputs
//   lib/guess_levels.lib.glsl   the pyramid; the coarser level is at `coarser_rect`
// In and out
//   levels_img   the same pyramid: rgb color and a coc of the level at `rect`

#include "lib/guess_levels.lib.glsl"  // is_known, coarser_at

layout(local_size_x = PIXEL_GROUP, local_size_y = PIXEL_GROUP) in;

uniform ivec4 rect;          // corner and size of the level
uniform ivec4 coarser_rect;  // those of the next coarser level
layout(rgba32f) uniform image2D levels_img;

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(at, rect.zw))) return;
    if (is_known(imageLoad(levels_img, rect.xy + at))) return;
    imageStore(levels_img, rect.xy + at, coarser_at(at, coarser_rect));
}

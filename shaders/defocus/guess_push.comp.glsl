// Fills the unknown texels of a level of the pyramid from the next coarser level.
//
// Inputs
//   lib/guess_levels.lib.glsl
// Output
//   levels_img   the same pyramid; the level at `place` is read and written

#include "lib/guess_levels.lib.glsl"

layout(local_size_x = PIXEL_GROUP, local_size_y = PIXEL_GROUP) in;

uniform ivec4 place;          // corner and size of the level
uniform ivec4 coarser_place;
layout(rgba32f) uniform image2D levels_img;

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(at, place.zw))) return;
    if (is_known(imageLoad(levels_img, place.xy + at))) return;
    imageStore(levels_img, place.xy + at, coarser_at(at, coarser_place));
}

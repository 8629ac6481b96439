// Adds the blurred view through a part of the lens to the sum of all parts, and empties the lists of
// part_links.comp.glsl for the next part.
//
// Inputs
//   view_buf   half floats of the blurred view: rgb times the known share, a the known share
//   front_buf  ALL_DEPTHS: half floats of the blurred view of what is in front of the focus: rgb times coverage, a
//              coverage
//   lib/lens_part.lib.glsl   has the part's share of the light
//   lib/tile_mask.lib.glsl   the tiles that have a view
//   lib/tile_numbers.lib.glsl   the tiles whose cells are emptied: those of all pixels with a view
//   is_first  true before the first part: the sum is only set to 0, and no view is added
// Outputs
//   sum_buf   rgba of each pixel, the sum of the views times their share of the light (read and written)
//   head_buf  0 for the cells of these tiles; it has one row and one column more than the picture

#include "lib/halves.lib.glsl"  // floats_of
#include "lib/lens_part.lib.glsl"  // lens_part_at
#include "lib/tile_mask.lib.glsl"  // is_active
#include "lib/tile_numbers.lib.glsl"  // listed_pixel

layout(local_size_x = TILE, local_size_y = TILE) in;

layout(std430) readonly buffer view_block { uvec2 view_buf[]; };
#ifdef ALL_DEPTHS
layout(std430) readonly buffer front_block { uvec2 front_buf[]; };
#endif
layout(std430) buffer sum_block { vec4 sum_buf[]; };
uniform ivec2 picture_size;
uniform bool is_first;
layout(std430) writeonly buffer head_block { uint head_buf[]; };

vec4 view_of(int pixel) {
    vec4 view = floats_of(view_buf[pixel]);
#ifdef ALL_DEPTHS
    vec4 front = floats_of(front_buf[pixel]);
    view = front + (1.0 - front.a) * view;
#endif
    return view;
}

void main() {
    ivec2 at = listed_pixel();
    if (any(greaterThan(at, picture_size))) return;
    head_buf[at.y * (picture_size.x + 1) + at.x] = 0u;
    if (any(greaterThanEqual(at, picture_size)) || !(is_first || is_active(at))) return;
    int pixel = at.y * picture_size.x + at.x;
    vec4 sum = vec4(0.0);
    if (!is_first) sum = sum_buf[pixel] + lens_part_at(at, picture_size).w * view_of(pixel);
    sum_buf[pixel] = sum;
}

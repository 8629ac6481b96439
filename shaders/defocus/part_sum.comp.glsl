// Adds the blurred view through a part of the lens to the sum of all parts, and empties the lists of
// part_links.comp.glsl for the next part.
//
// Inputs
//   view_tx   blurred view: rgb times the known share, a the known share
//   front_tx  ALL_DEPTHS: blurred view of what is in front of the focus, rgb times coverage, a coverage
//   lib/lens_part.lib.glsl   has the part's share of the light
//   lib/tile_mask.lib.glsl   the tiles that have a view
//   lib/tile_numbers.lib.glsl   the tiles whose cells are emptied: those of all pixels with a view
//   is_first  true before the first part: the sum is only set to 0, and no view is added
// Outputs
//   sum_img   rgba, the sum of the views times their share of the light (read and written)
//   head_buf  0 for the cells of these tiles; it has one row and one column more than the picture

#include "lib/lens_part.lib.glsl"  // lens_part_at
#include "lib/tile_mask.lib.glsl"  // is_active
#include "lib/tile_numbers.lib.glsl"  // listed_pixel

layout(local_size_x = TILE, local_size_y = TILE) in;

uniform sampler2D view_tx;
uniform bool is_first;
#ifdef ALL_DEPTHS
uniform sampler2D front_tx;
#endif
layout(rgba32f) uniform image2D sum_img;
layout(std430) writeonly buffer head_block { uint head_buf[]; };

vec4 view_at(ivec2 at) {
    vec4 view = texelFetch(view_tx, at, 0);
#ifdef ALL_DEPTHS
    vec4 front = texelFetch(front_tx, at, 0);
    view = front + (1.0 - front.a) * view;
#endif
    return view;
}

void main() {
    ivec2 at = listed_pixel(), size = imageSize(sum_img);
    if (any(greaterThan(at, size))) return;
    head_buf[at.y * (size.x + 1) + at.x] = 0u;
    if (any(greaterThanEqual(at, size)) || !(is_first || is_active(at))) return;
    vec4 sum = vec4(0.0);
    if (!is_first) sum = imageLoad(sum_img, at) + lens_part_at(at, size).w * view_at(at);
    imageStore(sum_img, at, sum);
}

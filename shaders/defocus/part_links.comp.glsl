// Moves every surface to its position in the view through one part of the lens, and adds it to the list of the cell that it reaches there. part_view.comp.glsl draws the view from these lists.
//
// Inputs
//   coc_tx    r signed coc (circle of confusion, diameter in pixels, negative in front of the focus)
//   lib/surface_numbers.lib.glsl   the numbers of the surfaces of each pixel
//   lib/part_link.lib.glsl       the surfaces (part_surfaces.comp.glsl)
//   lib/lens_part.lib.glsl       the part of the lens
//   read_buf      for each tile of TILE x TILE cells, row by row, a bit for each tile of pixels that reads its lists: 1
//                 the tile at the same place, 2 the one before it in x, 4 in y, 8 in both
//   lib/tile_numbers.lib.glsl    the tiles whose surfaces may move there
// Outputs
//   head_buf  for each cell the first surface of its list, plus 1; 0 for an empty list. A cell is the square between
//             four neighboring pixel centers: cell (x, y) lists the surfaces between the pixels (x - 1, y - 1) and
//             (x, y). There is one row and one column of cells more than there are of pixels
//   lib/part_link.lib.glsl   the links of the lists, in any order; part_order.comp.glsl puts them in order

#include "lib/surface_numbers.lib.glsl"  // front_index, mixed_index, List, list_at, least_px
#include "lib/lens_part.lib.glsl"  // lens_part_at
#include "lib/part_link.lib.glsl"  // link_coc, write_link
#include "lib/tile_numbers.lib.glsl"  // listed_pixel

layout(local_size_x = TILE, local_size_y = TILE) in;

layout(std430) buffer head_block { uint head_buf[]; };
layout(std430) readonly buffer read_block { uint read_buf[]; };
uniform int reads_across;  // tiles of cells in a row

// Coc in pixels up to which a surface does not move, and from which it moves wholly.
#define STILL_PX 0.75
#define MOVED_PX 2.25

// True if one of the four pixels around a cell is in a tile that reads lists. The cells of the first row and column of a
// tile also touch pixels of the tiles before it.
bool is_read(ivec2 cell) {
    bvec2 touches = equal(cell % TILE, ivec2(0));
    uint readers = 1u | (touches.x ? 2u : 0u) | (touches.y ? 4u : 0u) | (all(touches) ? 8u : 0u);
    return (read_buf[cell.y / TILE * reads_across + cell.x / TILE] & readers) != 0u;
}

// The coc by which a surface moves. With ALL_DEPTHS, what is in focus keeps its place, so that it stays as sharp as its pixels.
float moved_px(float coc) {
#ifdef ALL_DEPTHS
    return coc * smoothstep(STILL_PX, MOVED_PX, abs(coc));
#else
    return coc;
#endif
}

// Adds the surface number `index`, of the pixel `at`, to the list of the cell that it moves to.
void link(uint index, ivec2 at) {
    float coc = link_coc(index + 1u);
    if (coc <= least_px) return;
    vec2 view_position = vec2(at) + moved_px(coc) * lens_part_at(at, textureSize(coc_tx, 0)).xy;
    ivec2 cell = ivec2(floor(view_position)) + 1, cells = textureSize(coc_tx, 0) + 1;
    if (any(lessThan(cell, ivec2(0))) || any(greaterThanEqual(cell, cells))) return;
    if (!is_read(cell)) return;
    uint previous_link = atomicExchange(head_buf[cell.y * cells.x + cell.x], index + 1u);
    write_link(index + 1u, previous_link, fract(view_position));
}

void main() {
    ivec2 at = listed_pixel();
    if (any(greaterThanEqual(at, textureSize(coc_tx, 0)))) return;
    List list = list_at(at);
    if (!list.has_front) {  // the visible surface is not in the list: it is the pixel itself
        link(front_index(at), at);
#ifdef ALL_DEPTHS
        link(mixed_index(at), at);
#endif
    }
    for (uint i = list.first; i < list.end; ++i) link(i, at);
}

// Puts the surfaces of each cell in order, near to far, so that part_view.comp.glsl can merge the cells around a pixel
// and stop at what covers it. Surfaces of the same coc are in the order of their numbers.
//
// Input
//   lib/tile_numbers.lib.glsl   the tiles whose cells are put in order
// In and out
//   head_buf    for each cell, the number of the first surface of its list plus 1; 0 for an empty list
//   link_buf    for each surface, the next one of its list in the same form, and its coc (lib/part_link.lib.glsl)

#include "lib/part_link.lib.glsl"  // next_link, link_coc, set_next_link
#include "lib/tile_numbers.lib.glsl"  // listed_pixel

layout(local_size_x = TILE, local_size_y = TILE) in;

uniform ivec2 cells;    // cells across and down
layout(std430) buffer head_block { uint head_buf[]; };

bool is_nearer(uint link, uint other) {
    float coc = link_coc(link), other_coc = link_coc(other);
    return coc < other_coc || coc == other_coc && link < other;
}

void main() {
    ivec2 cell = listed_pixel();
    if (any(greaterThanEqual(cell, cells))) return;
    int index = cell.y * cells.x + cell.x;
    uint ordered = head_buf[index];  // the first surface of those that are in order
    if (ordered == 0u) return;
    uint link = next_link(ordered);
    if (link == 0u) return;
    set_next_link(ordered, 0u);
    while (link != 0u) {
        uint following = next_link(link), before = 0u, after = ordered;
        while (after != 0u && is_nearer(after, link)) {
            before = after;
            after = next_link(after);
        }
        set_next_link(link, after);
        if (before == 0u) ordered = link;
        else set_next_link(before, link);
        link = following;
    }
    head_buf[index] = ordered;
}

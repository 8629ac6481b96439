// Decides in which tiles the view through a part of the lens is blurred: where it has discs that can be seen, and, for
// what is in front of the focus, where that is seen or spreads to.
//
// Inputs
//   mark_buf      what part_view.comp.glsl found in each tile (lib/view_marks.lib.glsl)
//   lib/tile_mask.lib.glsl   the tiles that have a view
//   reach_tiles   how many tiles far the discs in front of the focus spread
// Output
//   mask_buf      masks as in lib/tile_mask.lib.glsl: the first for the view, the second, from `mask_words` on, for what
//                 is in front of the focus

#include "lib/view_marks.lib.glsl"  // is_marked, IS_BLURRED, HAS_FRONT, tiles
#include "lib/tile_mask.lib.glsl"  // is_tile_active

layout(local_size_x = TILE_GROUP, local_size_y = TILE_GROUP) in;

layout(std430) writeonly buffer mask_block { uint mask_buf[]; };
uniform int mask_words;
uniform int reach_tiles;

void main() {
    ivec2 tile = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(tile, tiles))) return;
    bool is_active = is_tile_active(tile), has_front = false;
    for (int y = -reach_tiles; y <= reach_tiles; ++y)
        for (int x = -reach_tiles; x <= reach_tiles; ++x) {
            ivec2 other = clamp(tile + ivec2(x, y), ivec2(0), tiles - 1);
            has_front = has_front || is_marked(other, HAS_FRONT);
        }
    int word = tile.y * tiles.x + tile.x;
    mask_buf[word] = uint(is_active && is_marked(tile, IS_BLURRED));
    mask_buf[mask_words + word] = uint(is_active && has_front);
}

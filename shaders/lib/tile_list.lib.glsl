// The active tiles of a layer, so that a pass runs on these alone: one workgroup a tile.
//
// The list begins with the numbers of workgroups of two kinds of later passes (glDispatchComputeIndirect): passes over
// the tiles of the layer, in slices (lib/list_slice.lib.glsl), and passes over the tiles of the picture, of which a
// tile of a smaller layer covers several. tile_reach.comp.glsl writes the list; the order of the tiles differs from
// run to run.

#include "lib/list_slice.lib.glsl"  // slice_start, slice_end

layout(std430) buffer tile_list_block {
    uint layer_groups[3];    // workgroups of a pass over the layer's tiles: x, y, z
    uint picture_groups[3];  // workgroups of a pass over the picture's tiles
    uint tile_count;
    uint listed_tiles[];  // y << 16 | x
};

ivec2 listed_tile(uint slot) {
    return ivec2(listed_tiles[slot] & 0xffffu, listed_tiles[slot] >> 16);
}

// Loops over the slice of the list, in the main of a later pass; DO is a function of the tile's position.
#define FOR_EACH_TILE(DO) \
    uint slot = slice_start(tile_count) + gl_WorkGroupID.x; \
    if (slot >= slice_end(tile_count)) return; \
    do DO(listed_tile(slot)); while ((slot += gl_NumWorkGroups.x) < slice_end(tile_count));

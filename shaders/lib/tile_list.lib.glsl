// The active tiles of a layer, so that a pass runs on these alone: one workgroup a tile.
//
// The list begins with the workgroups of two later passes (glDispatchComputeIndirect): one of the
// layer's size, and one of the picture's, where a tile stands for several. The order of the tiles
// differs from run to run.

#include "lib/list_slice.lib.glsl"

layout(std430) buffer tile_list_block {
    uint layer_groups[3];
    uint picture_groups[3];
    uint tile_count;
    uint listed_tiles[];  // y << 16 | x
};

#define TILE_GROUPS_MAX 65535u  // what OpenGL promises; longer lists are walked in strides

// The number of slices of the pass at the layer's size (lib/list_slice.lib.glsl).
void list_tile(ivec2 tile, uint slices) {
    uint slot = atomicAdd(tile_count, 1u);
    if (slot % slices == 0u && slot / slices < TILE_GROUPS_MAX) atomicAdd(layer_groups[0], 1u);
    if (slot < TILE_GROUPS_MAX) atomicAdd(picture_groups[0], 1u);
    listed_tiles[slot] = uint(tile.y) << 16 | uint(tile.x);
}

ivec2 listed_tile(uint slot) {
    return ivec2(listed_tiles[slot] & 0xffffu, listed_tiles[slot] >> 16);
}

// Loops over the list, in the main of a later pass.
#define FOR_EACH_TILE(DO) \
    for (uint slot = slice_start(tile_count) + gl_WorkGroupID.x; \
         slot < slice_end(tile_count); slot += gl_NumWorkGroups.x) \
        DO(listed_tile(slot));

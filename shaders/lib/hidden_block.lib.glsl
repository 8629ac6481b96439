// The pixels to guess, see lib/pixel_list.lib.glsl: the first hidden pixel of each block of 2 x 2 from the
// front of the list on, because it computes what its block shares, and the others from its end backwards.

#include "lib/list_slice.lib.glsl"

#define MARK_WHOLE 0x80000000u  // flag of a pixel whose guess serves its whole block
#define PLACE_MASK 0x7fffu      // the coordinates without the flag

layout(std430) buffer block_list_block {
    uint first_groups[3];  // workgroups of a pass over the first pixels of blocks,
    uint first_count;
    uint all_groups[3];    // and of one over all
    uint other_count;
    uint block_pixels[];   // y << 16 | x, with its flag
};

uint block_slot(uint slot) {
    return slot < first_count ? slot : uint(block_pixels.length()) - 1u - (slot - first_count);
}

// Loops over the first `COUNT` of the list, in the main of a later pass.
#define FOR_EACH_BLOCK(COUNT, DO) \
    uint count = COUNT, slot = slice_start(count) + gl_GlobalInvocationID.x; \
    if (slot >= slice_end(count)) return; \
    do DO(block_pixels[block_slot(slot)]); while ((slot += gl_NumWorkGroups.x * PIXELS_PER_GROUP) < slice_end(count));

ivec2 place_of(uint listed) { return ivec2(listed & PLACE_MASK, listed >> 16 & PLACE_MASK); }

// One of the 3 x 3 blocks over which measurements are averaged.
ivec2 block_beside(ivec2 block, int i, ivec2 blocks) {
    return clamp(block + ivec2(i % 3, i / 3) - 1, ivec2(0), blocks - 1);
}

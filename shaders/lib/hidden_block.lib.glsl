// Flags of a listed pixel, in bits that its coordinates do not need (lib/pixel_list.lib.glsl).

#define MARK_FIRST 0x8000u      // the first hidden pixel of its block of 2 x 2: it computes the block's cost
#define MARK_WHOLE 0x80000000u  // its guess serves the whole block

#define PLACE_MASK 0x7fff  // the coordinates without the flags

// One of the 3 x 3 blocks over which measurements are averaged.
ivec2 block_beside(ivec2 block, int i, ivec2 blocks) {
    return clamp(block + ivec2(i % 3, i / 3) - 1, ivec2(0), blocks - 1);
}

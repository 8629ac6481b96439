// Blocks of 2 x 2 pixels of a layer in which pixels are hidden and have to be guessed. Of lib/two_lists.lib.glsl, the
// first list has the first hidden pixel of each block, which computes what the whole block shares; the second list has
// the other hidden pixels that get a guess of their own.

#include "lib/two_lists.lib.glsl"  // for the files that include this one

uniform ivec2 layer_size;  // in pixels of its own; a smaller layer is in the corner of the images

#define NO_COST (-1.0)  // cost of a direction (hidden_cost.comp.glsl) that has no two ends; others are above -0.5
#define ALIKE_VARIANCE 0.04  // variance in compressed color: ends that differ by 0.2 have much less weight

#define MARK_WHOLE 0x80000000u  // flag of a word: the pixel's guess serves its whole block

// Block i, 0..8, of the 3 x 3 blocks around one, over which measurements are averaged.
ivec2 neighbor_block(ivec2 block, int i) {
    return clamp(block + ivec2(i % 3, i / 3) - 1, ivec2(0), (layer_size - 1) / 2);
}

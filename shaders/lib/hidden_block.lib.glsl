// Blocks of 2 x 2 pixels of a layer in which pixels are hidden and have to be guessed. Of lib/two_lists.lib.glsl, the
// first list has the first hidden pixel of each block, which computes what the whole block shares; the second list has
// the other hidden pixels that get a guess of their own.

#include "lib/two_lists.lib.glsl"  // for the files that include this one

uniform ivec2 layer_size;  // in pixels of its own; a smaller layer is in the corner of the images

#define ALIKE_VARIANCE 0.04  // variance in compressed color: ends that differ by 0.2 have much less weight

#define MARK_WHOLE 0x80000000u  // flag of a word: the pixel's guess serves its whole block

// Block i, 0..8, of the 3 x 3 blocks around one, over which measurements are averaged.
ivec2 neighbor_block(ivec2 block, int i) {
    return clamp(block + ivec2(i % 3, i / 3) - 1, ivec2(0), (layer_size - 1) / 2);
}

// With LINES, behind a wide thing the guess follows whole rows and columns (lib/steadiness_system.lib.glsl), and not
// the nearest ends alone. A gap is the number of pixels between the two ends of a row or a column, and the shorter one counts.
uniform int line_step_px;  // unit of lengths along a line, in proportion to the picture
#define NARROW_GAP 1.3     // gap, in steps, up to which the ends alone decide
#define WIDE_GAP 2.7       // gap from which lines alone decide
#define NO_GAP 1e6         // gap of a line without two ends

// Degree to which the guess follows lines, 0..1. `across` and `down` have the steps to the ends of row and column, and
// one of them must be within `most_px`.
float line_share_of(ivec2 across, ivec2 down, int most_px) {
#ifdef LINES
    float row_px = min(across.x, across.y) > 0 ? float(across.x + across.y) : NO_GAP;
    float column_px = min(down.x, down.y) > 0 ? float(down.x + down.y) : NO_GAP;
    ivec4 ends_px = ivec4(across, down);
    bool is_near = false;
    for (int i = 0; i < 4; ++i) is_near = is_near || (ends_px[i] > 0 && ends_px[i] <= most_px);
    float wide_share = smoothstep(NARROW_GAP, WIDE_GAP, min(row_px, column_px) / float(line_step_px));
    return is_near && min(row_px, column_px) < NO_GAP ? wide_share : 0.0;
#else
    return 0.0;
#endif
}

// Looks up which pixels of a layer are visible, and the distances to the next visible ones.
//
// Input
//   bits_buf   a bit for each pixel and direction, set if the pixel is visible (lib/hidden.lib.glsl); written by
//              visible_bits_all.comp.glsl and hidden_blocks.comp.glsl
//
// The nearest visible pixels ahead and back along a direction are the ends of a hidden pixel.

#include "lib/bit_search.lib.glsl"  // lowest_bit, highest_bit
#include "lib/hidden.lib.glsl"  // line_of, position_of, words_per_line, first_word

layout(std430) readonly buffer bits_block { uint bits_buf[]; };

// True if a pixel is visible, by the mask of direction 0, whose lines are the rows.
bool is_visible(ivec2 at, ivec2 size) {
    uint word = bits_buf[at.y * words_per_line(0, size) + (at.x >> 5)];
    return (word >> (at.x & 31) & 1u) == 1u;
}

// Steps from position i of a line ahead to the next visible pixel; 0 for none. The line has `per_line` words from
// `first` on.
int steps_ahead(int first, int per_line, int i) {
    int word = i >> 5;
    uint bits = bits_buf[first + word] & (~0u << (i & 31));
    while (bits == 0u) {
        if (++word >= per_line) return 0;
        bits = bits_buf[first + word];
    }
    return word * 32 + lowest_bit(bits) - i;
}

// Steps from position i of a line back to the previous visible pixel; 0 for none.
int steps_back(int first, int i) {
    int word = i >> 5;
    uint bits = bits_buf[first + word] & ((2u << (i & 31)) - 1u);
    while (bits == 0u) {
        if (--word < 0) return 0;
        bits = bits_buf[first + word];
    }
    return i - (word * 32 + highest_bit(bits));
}

uniform int reach_px;  // hidden pixels farther than this from any visible pixel are never uncovered

// True if even the nearest end is out of reach. `ends` has the steps ahead and back along each direction; 0 for none.
// Loops for such a pixel end after one round, which, unlike a branch, saves a software rasterizer time.
bool is_beyond_reach(ivec2 ends[HIDDEN_DIRECTIONS]) {
    int nearest = reach_px + 1;
    for (int k = 0; k < HIDDEN_DIRECTIONS; ++k) {
        if (ends[k].x > 0) nearest = min(nearest, ends[k].x);
        if (ends[k].y > 0) nearest = min(nearest, ends[k].y);
    }
    return nearest > reach_px;
}

// Steps from a hidden pixel to the next visible one along direction k, forwards and back; 0 for none.
ivec2 ends_of(int k, ivec2 at, ivec2 size) {
    int per_line = words_per_line(k, size), i = position_of(k, at);
    int first = first_word(k, size) + line_of(k, at, size) * per_line;
    return ivec2(steps_ahead(first, per_line, i), steps_back(first, i));
}

// Number of visible pixels in a row along direction k, ahead or back, from a visible pixel on; at most 32.
int visible_in_row(int k, ivec2 at, bool is_ahead, ivec2 size) {
    int per_line = words_per_line(k, size), i = position_of(k, at), word = i >> 5, shift = i & 31;
    int first = first_word(k, size) + line_of(k, at, size) * per_line, next = is_ahead ? word + 1 : word - 1;
    uint bits = bits_buf[first + word], more = next == clamp(next, 0, per_line - 1) ? bits_buf[first + next] : 0u;
    uint ahead = bits >> shift | more << 1 << (31 - shift), back = bits << (31 - shift) | more >> 1 >> shift;
    int end = is_ahead ? lowest_bit(~ahead) : 31 - highest_bit(~back);
    return end < 0 ? 32 : end;
}

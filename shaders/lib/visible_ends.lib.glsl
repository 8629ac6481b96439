// Finds the visible pixels nearest to a hidden one. Those ahead and back along a direction are its ends.
//
// Input
//   words_buf   for each word of the masks of visible pixels, the next ones before and behind it in its line in which any
//               bit is set (visible_words.comp.glsl)

#include "lib/visible_bits.lib.glsl"  // bits_buf, lowest_bit, highest_bit, first_word, NO_WORD ...

layout(std430) readonly buffer words_block { uint words_buf[]; };

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
    int per_line = words_per_line(k, size), i = position_of(k, at), word = i >> 5;
    int first = first_word(k, size) + line_of(k, at, size) * per_line;
    uint bits = bits_buf[first + word], both = words_buf[first + word];
    int next = min(int(both >> 16), per_line - 1), previous = min(int(both & 0xffffu), per_line - 1);
    uint ahead = bits & (~0u << (i & 31)), back = bits & ((2u << (i & 31)) - 1u);
    uint far_ahead = both >> 16 == NO_WORD ? 0u : bits_buf[first + next];
    uint far_back = (both & 0xffffu) == NO_WORD ? 0u : bits_buf[first + previous];
    int end = ahead != 0u ? word * 32 + lowest_bit(ahead) : next * 32 + lowest_bit(far_ahead);
    int begin = back != 0u ? word * 32 + highest_bit(back) : previous * 32 + highest_bit(far_back);
    return ivec2((ahead | far_ahead) != 0u ? end - i : 0, (back | far_back) != 0u ? i - begin : 0);
}

// The same along all directions.
ivec2[HIDDEN_DIRECTIONS] all_ends_of(ivec2 at, ivec2 size) {
    return ivec2[](ends_of(0, at, size), ends_of(1, at, size), ends_of(2, at, size), ends_of(3, at, size));
}

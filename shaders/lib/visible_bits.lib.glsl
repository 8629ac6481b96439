// Looks up which pixels of a layer are visible.
//
// Input
//   bits_buf   a bit for each pixel and direction, set if the pixel is visible (lib/hidden.lib.glsl,
//              visible_bits.comp.glsl)

#include "lib/bit_search.lib.glsl"  // lowest_bit, highest_bit
#include "lib/hidden.lib.glsl"  // line_of, position_of, words_per_line, first_word

layout(std430) readonly buffer bits_block { uint bits_buf[]; };

// True if a pixel is visible, by the mask of direction 0, whose lines are the rows.
bool is_visible(ivec2 at, ivec2 size) {
    uint word = bits_buf[at.y * words_per_line(0, size) + (at.x >> 5)];
    return (word >> (at.x & 31) & 1u) == 1u;
}

// The bits of pixels of a line of direction k from one on, as many as are in the same word; the first one in bit 0.
uint visible_from(int k, ivec2 at, ivec2 size) {
    int i = position_of(k, at);
    return bits_buf[first_word(k, size) + line_of(k, at, size) * words_per_line(k, size) + (i >> 5)] >> (i & 31);
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

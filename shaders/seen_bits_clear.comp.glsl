// Clears a layer's hidden pixels in the masks of visible pixels.
//
// Input
//   pixel list   the hidden pixels
// Output
//   bits_buf     numbered as in lib/hidden.lib.glsl

#include "lib/hidden.lib.glsl"
#include "lib/pixel_list.lib.glsl"

layout(local_size_x = PIXELS_PER_GROUP) in;

uniform ivec2 size;
layout(std430) buffer bits_block { uint bits_buf[]; };

void clear_pixel(ivec2 at) {
    for (int k = 0; k < HIDDEN_DIRECTIONS; ++k) {
        int i = position_of(k, at);
        int word = first_word(k, size) + line_of(k, at, size) * words_per_line(k, size) + (i >> 5);
        atomicAnd(bits_buf[word], ~(1u << (i & 31)));
    }
}

void main() { FOR_EACH_LISTED(clear_pixel) }

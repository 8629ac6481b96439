// Finds, for each word of the masks of visible pixels, the next words before and behind it in its line that have a visible
// pixel (lib/visible_ends.lib.glsl): a search over many hidden pixels then reads two words. An invocation (x, y) works on
// line x of direction y (lib/hidden.lib.glsl).
//
// Input
//   bits_buf    the masks (visible_bits.comp.glsl)
// Output
//   words_buf   for each word the numbers of both in the line, NO_WORD for none: next << 16 | previous

#include "lib/hidden.lib.glsl"  // words_per_line, lines_of, first_word, NO_WORD

layout(local_size_x = WORD_GROUP) in;

uniform ivec2 layer_size;
layout(std430) readonly buffer bits_block { uint bits_buf[]; };
layout(std430) buffer words_block { uint words_buf[]; };

void main() {
    int line = int(gl_GlobalInvocationID.x), k = int(gl_GlobalInvocationID.y);
    if (line >= lines_of(k, layer_size)) return;
    int per_line = words_per_line(k, layer_size), first = first_word(k, layer_size) + line * per_line, word = 0;
    uint previous = NO_WORD, next = NO_WORD;
    do {
        words_buf[first + word] = previous;
        if (bits_buf[first + word] != 0u) previous = uint(word);
    } while (++word < per_line);
    do {
        --word;
        words_buf[first + word] |= next << 16;
        if (bits_buf[first + word] != 0u) next = uint(word);
    } while (word > 0);
}

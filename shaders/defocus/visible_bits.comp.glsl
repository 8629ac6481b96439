// Marks which pixels of a layer are visible, in the masks of lib/hidden.lib.glsl: those in active tiles that nearer layers
// leave open. An invocation (x, y) writes word x of direction y.
//
// The masks have a bit for each pixel and direction k: 0 along rows, 1 along columns, 2 and 3 along the two diagonals.
// A direction divides the layer into lines, and a line into words of 32 bits; the position in a line is x for rows, and
// y for all others.
//
// Inputs
//   layer_tx        a below 0 in hidden pixels
//   tile_mask_buf   the active tiles, and those with hidden pixels (layer_split.comp.glsl)
//   are_hidden_visible   all pixels in active tiles count as visible
// Output
//   bits_buf        32 pixels a word, along each direction; bits beyond the picture's edge are 0

#include "lib/bit_search.lib.glsl"  // lowest_bit, highest_bit
#include "lib/hidden.lib.glsl"  // pixel_of, words_per_line, lines_of, first_word, DIRECTION, TILE_WITH_HIDDEN
#include "lib/tile_mask.lib.glsl"  // tile_word

layout(local_size_x = WORD_GROUP) in;

uniform ivec2 layer_size;
uniform sampler2D layer_tx;
uniform bool are_hidden_visible;
layout(std430) writeonly buffer bits_block { uint bits_buf[]; };

// Number of pixels from here on, along a direction, in the same tile.
int run_in_tile(ivec2 at, ivec2 direction) {
    ivec2 in_tile = at & (TILE - 1);
    int run = direction.y == 0 ? TILE : TILE - in_tile.y;
    if (direction.x > 0) run = min(run, TILE - in_tile.x);
    return direction.x < 0 ? min(run, in_tile.x + 1) : run;
}

// The first position of a line of direction k inside the picture, and the one after its last. The position on a
// diagonal is y. Line n of direction 2 has x = y + n - height, so that x is inside from y = height - n on; line n of
// direction 3 has x = n - y, which is inside from y = n + 1 - width to y = n.
ivec2 line_range(int k, int line, ivec2 size) {
    if (k < 2) return ivec2(0, k == 0 ? size.x : size.y);
    ivec2 ends = k == 2 ? ivec2(size.y - line, size.x + size.y - line) : ivec2(line + 1 - size.x, line + 1);
    return clamp(ends, ivec2(0), ivec2(size.y));
}

// The bits of a word of a line of direction k, from the pixel `begin` on: x in active tiles, y in those with hidden pixels.
// Goes through the word by stretches of pixels in the same tile.
uvec2 active_bits(int k, int line, int begin) {
    ivec2 ends = line_range(k, line, layer_size);
    uvec2 bits = uvec2(0u);
    for (int i = max(begin, ends.x), end = min(begin + 32, ends.y); i < end;) {
        ivec2 at = pixel_of(k, line, i, layer_size);
        int run = min(run_in_tile(at, DIRECTION[k]), end - i);
        uint stretch = (~0u >> (32 - run)) << (i - begin), tile = tile_word(at / TILE);
        bits |= uvec2(tile != 0u ? stretch : 0u, tile >= TILE_WITH_HIDDEN ? stretch : 0u);
        i += run;
    }
    return bits;
}

// The bits of these whose pixels are visible. The one of bit 0 is `first`.
uint visible_bits(uint bits, ivec2 first, ivec2 direction) {
    uint visible = 0u;
    int i = max(lowest_bit(bits), 0), last = highest_bit(bits);
    do visible |= uint(texelFetch(layer_tx, first + i * direction, 0).a >= 0.0) << i; while (++i <= last);
    return visible & bits;
}

void main() {
    int word = int(gl_GlobalInvocationID.x), k = int(gl_GlobalInvocationID.y);
    // A software rasterizer divides whole numbers one by one, and floats all at once. The quotient of floats may be a line
    // too large or too small.
    int per_line = words_per_line(k, layer_size), line = int(float(word) / float(per_line));
    if (word < line * per_line) --line;
    if (word >= (line + 1) * per_line) ++line;
    int begin = (word - line * per_line) * 32;
    if (line >= lines_of(k, layer_size)) return;
    uvec2 bits = active_bits(k, line, begin);
    ivec2 first = pixel_of(k, line, begin, layer_size);
    uint searched = are_hidden_visible ? 0u : bits.y;
    bits_buf[first_word(k, layer_size) + word] = bits.x & ~searched | visible_bits(searched, first, DIRECTION[k]);
}

// Marks every pixel in the active tiles of several layers as visible, in the masks of lib/hidden.lib.glsl; later,
// hidden_blocks.comp.glsl clears the hidden ones. An invocation (x, y, z) writes word x of direction y of layer z.
//
// The masks have a bit for each pixel and direction k: 0 along rows, 1 along columns, 2 and 3 along the two diagonals.
// A direction divides the layer into lines, and a line into words of 32 bits; the position in a line is x for rows, and
// y for all others.
//
// Inputs
//   tile_mask_buf   masks of the layers' active tiles (lib/tile_mask.lib.glsl), `tile_words` words each
//   layer_sizes     of each layer, in its own pixels
// Output
//   bits_buf   for each layer `bits_words` words: 32 pixels a word, along each direction; bits beyond the picture's
//              edge are 0

#include "lib/hidden.lib.glsl"  // pixel_of, words_per_line, lines_of, first_word, DIRECTION

layout(local_size_x = WORD_GROUP) in;

uniform ivec2 layer_sizes[2 * LAYERS_MAX];
uniform int tile_words, bits_words;  // words of a layer in tile_mask_buf, and in bits_buf
layout(std430) readonly buffer tile_mask_block { uint tile_mask_buf[]; };
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

void main() {
    int word = int(gl_GlobalInvocationID.x), k = int(gl_GlobalInvocationID.y), layer = int(gl_GlobalInvocationID.z);
    ivec2 size = layer_sizes[layer];
    int per_line = words_per_line(k, size), line = word / per_line, begin = word % per_line * 32;
    if (line >= lines_of(k, size)) return;
    ivec2 ends = line_range(k, line, size);
    int first_tile = layer * tile_words, tiles_across = (size.x + TILE - 1) / TILE;
    uint bits = 0u;
    // Goes through the word by stretches of pixels in the same tile, and sets their bits if the tile is active.
    for (int i = max(begin, ends.x), end = min(begin + 32, ends.y); i < end;) {
        ivec2 at = pixel_of(k, line, i, size), tile = at / TILE;
        int run = min(run_in_tile(at, DIRECTION[k]), end - i);
        bool is_active = tile_mask_buf[first_tile + tile.y * tiles_across + tile.x] != 0u;
        if (is_active) bits |= (~0u >> (32 - run)) << (i - begin);
        i += run;
    }
    bits_buf[layer * bits_words + first_word(k, size) + word] = bits;
}

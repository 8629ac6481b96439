// Clears what is measured of the blocks of 2 x 2 pixels beside those with hidden pixels: hidden_fill.comp.glsl averages over
// all blocks around, and these are not measured. An invocation (x, y) works on the 16 blocks in word x of the block row y
// (lib/hidden.lib.glsl).
//
// Inputs
//   bits_buf        the visible pixels (visible_bits.comp.glsl)
//   tile_mask_buf   the active tiles (lib/tile_mask.lib.glsl)
// Outputs, one texel a block
//   out_cost_img    NO_COST
//   out_match_img   with MATCHED, the same

#include "lib/bit_search.lib.glsl"  // lowest_bit
#include "lib/hidden.lib.glsl"  // words_per_line, NO_COST
#include "lib/tile_mask.lib.glsl"  // is_tile_active

layout(local_size_x = WORD_GROUP) in;

uniform ivec2 layer_size;
layout(std430) readonly buffer bits_block { uint bits_buf[]; };
layout(rgba32f) uniform writeonly image2D out_cost_img;
#ifdef MATCHED
layout(rgba32f) uniform writeonly image2D out_match_img;
#endif

#define BLOCK_BITS 0x55555555u  // the first pixels of the blocks of a word

// The blocks of a word with hidden pixels in active tiles, as bits of their first pixels; none outside the layer.
uint hidden_blocks(int word, int row) {
    int per_line = words_per_line(0, layer_size);
    if (word != clamp(word, 0, per_line - 1) || row != clamp(row, 0, (layer_size.y - 1) / 2)) return 0u;
    uint in_tiles = 0u;
    for (int i = 0; i < 32 / TILE; ++i) {
        ivec2 tile = ivec2(word * (32 / TILE) + i, 2 * row / TILE);
        if (tile.x < tiles_across && is_tile_active(tile)) in_tiles |= ((1u << TILE) - 1u) << (i * TILE);
    }
    int rest = layer_size.x - 32 * word;  // pixels up to the layer's edge
    if (rest < 32) in_tiles &= (1u << rest) - 1u;
    uint visible = bits_buf[2 * row * per_line + word] & bits_buf[min(2 * row + 1, layer_size.y - 1) * per_line + word];
    uint hidden = in_tiles & ~visible;
    return (hidden | hidden >> 1) & BLOCK_BITS;
}

void main() {
    int per_line = words_per_line(0, layer_size), id = int(gl_GlobalInvocationID.x);
    int word = id % per_line, row = id / per_line;
    if (row > (layer_size.y - 1) / 2) return;
    uint own = hidden_blocks(word, row), around = 0u;
    for (int i = -1; i <= 1; ++i) {
        uint blocks = hidden_blocks(word, row + i);
        around |= blocks | blocks << 2 | blocks >> 2;
        around |= hidden_blocks(word - 1, row + i) >> 30 | hidden_blocks(word + 1, row + i) << 30;
    }
    uint rims = around & ~own;
    while (rims != 0u) {
        ivec2 block = ivec2(word * 16 + lowest_bit(rims) / 2, row);
        if (block.x <= (layer_size.x - 1) / 2) imageStore(out_cost_img, block, vec4(NO_COST));
#ifdef MATCHED
        if (block.x <= (layer_size.x - 1) / 2) imageStore(out_match_img, block, vec4(NO_COST));
#endif
        rims &= rims - 1u;
    }
}

// Lists the pixels of a layer for which guesses are made. Near visible pixels each hidden pixel has its own guess; deeper
// inside, the four pixels of a block share one, but with EACH_PIXEL they do not.
//
// Words: a pixel of a layer is visible if nearer layers leave it open, and hidden if the layer must be guessed there
// (lib/hidden.lib.glsl). A block has 2 x 2 pixels. From a hidden pixel, each of four directions leads both ways to the
// next visible pixel, its two ends.
//
// Inputs
//   layer_tx       a below 0 if hidden (lib/hidden.lib.glsl); tiles that are not active are hidden too
//   pixel list     the hidden pixels
// Output
//   two lists      first: the first hidden pixel of each block; second: the others that have a guess of their own
//                  (lib/hidden_block.lib.glsl)

#include "lib/hidden.lib.glsl"  // marked_known
#include "lib/hidden_block.lib.glsl"  // MARK_WHOLE, layer_size, PIXELS_PER_GROUP, append_word
#include "lib/pixel_list.lib.glsl"  // FOR_EACH_LISTED
#include "lib/tile_mask.lib.glsl"  // is_active

layout(local_size_x = PIXELS_PER_GROUP) in;

uniform sampler2D layer_tx;
uniform int slices;  // number of slices in which later passes work through the list
#ifdef EACH_PIXEL
#define MAY_SHARE false
#else
#define MAY_SHARE true
#endif
#define DEEP_PX 3  // distance from all visible pixels, along rows and columns, from which the guess is smooth

// True if an alpha is that of a pixel less than half known. Pixels of a surface that passes into the layer or out of it
// are marked as hidden before, but what is guessed beside them must not jump then.
bool is_unknown(float alpha) { return alpha < 0.0 && marked_known(alpha) < 0.5; }

// True if a pixel, or the nearest one inside the picture, is unknown or in a tile that is not active.
bool is_unknown_at(ivec2 at) {
    at = clamp(at, ivec2(0), layer_size - 1);
    return !is_active(at) || is_unknown(texelFetch(layer_tx, at, 0).a);
}

// The hidden pixels of a block in an active tile, x, and the unknown ones, y. Bit 0 is the first, 1 the one beside it,
// 2 and 3 those below.
uvec2 hidden_in(ivec2 first) {
    ivec2 last = layer_size - 1;
    uint hidden = 0u, unknown = 0u;
    for (int i = 0; i < 4; ++i) {
        float alpha = texelFetch(layer_tx, min(first + ivec2(i & 1, i >> 1), last), 0).a;
        hidden |= uint(alpha < 0.0) << i;
        unknown |= uint(is_unknown(alpha)) << i;
    }
    return uvec2(hidden, unknown);
}

// True if all pixels around the block up to a distance of DEEP_PX are unknown, along rows and columns. `first` is the
// first pixel of the block.
bool is_surrounded(ivec2 first) {
    if (!MAY_SHARE) return false;
    const int far = DEEP_PX + 1;
    return is_unknown_at(first - ivec2(DEEP_PX, 0)) && is_unknown_at(first + ivec2(far, 0)) &&
        is_unknown_at(first - ivec2(0, DEEP_PX)) && is_unknown_at(first + ivec2(0, far));
}

// Lists a hidden pixel, unless its block is listed as a whole. In the second round, pixels with a guess are not hidden.
void list_block(ivec2 at) {
    if (texelFetch(layer_tx, at, 0).a >= 0.0) return;
    ivec2 first = at & ~1, pixel_in_block = at - first;
    uvec2 hidden = hidden_in(first);
    uint earlier_bits = (1u << (pixel_in_block.x + 2 * pixel_in_block.y)) - 1u;
    bool is_first = (hidden.x & earlier_bits) == 0u, is_whole = hidden.y == 15u && is_surrounded(first);
    if (is_first || !is_whole)
        append_word(is_first, uint(at.y) << 16 | uint(at.x) | (is_whole ? MARK_WHOLE : 0u), slices);
}

void main() { FOR_EACH_LISTED(list_block) }

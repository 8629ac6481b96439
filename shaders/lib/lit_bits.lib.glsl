// One bit for each pixel of a picture, set if the pixel contains a highlight. Each block of 8 x 8 pixels has two words,
// the first one for its upper four rows. Only in these pixels has highlight_split.comp.glsl removed light.

layout(std430) buffer lit_block { uint lit_buf[]; };

// Index of the word, and mask of the bit, of a pixel in a picture of this size.
int lit_word(ivec2 at, ivec2 size) {
    int across = (size.x + HIGHLIGHT_BLOCK - 1) / HIGHLIGHT_BLOCK;
    ivec2 block = at / HIGHLIGHT_BLOCK;
    return 2 * (block.y * across + block.x) + (at.y >> 2 & 1);
}

uint lit_bit(ivec2 at) { return 1u << ((at.y & 3) * HIGHLIGHT_BLOCK + at.x % HIGHLIGHT_BLOCK); }

bool is_lit(ivec2 at, ivec2 size) { return (lit_buf[lit_word(at, size)] & lit_bit(at)) != 0u; }

// Which pixels of a picture hold a highlight, one bit each: two words for each block of 8 x 8 pixels, the
// first for its upper four rows. Only such pixels have a removed light (highlight_split.comp.glsl).

layout(std430) buffer lit_block { uint lit_buf[]; };

int lit_word(ivec2 at, ivec2 size) {
    int across = (size.x + HIGHLIGHT_BLOCK - 1) / HIGHLIGHT_BLOCK;
    ivec2 block = at / HIGHLIGHT_BLOCK;
    return 2 * (block.y * across + block.x) + (at.y >> 2 & 1);
}

uint lit_bit(ivec2 at) { return 1u << ((at.y & 3) * HIGHLIGHT_BLOCK + at.x % HIGHLIGHT_BLOCK); }

bool is_lit(ivec2 at, ivec2 size) { return (lit_buf[lit_word(at, size)] & lit_bit(at)) != 0u; }

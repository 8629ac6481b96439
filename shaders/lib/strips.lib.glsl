// Where a pixel is stored in a picture that the solution of rows writes and that of columns reads.
//
// With STRIPS, which is for CPUs, strips of 8 columns (STRIP_COLUMNS) are stored one after the other, each of them row
// by row: a CPU reads 8 columns, and writes 8 rows, in consecutive memory. In plain row order each step down a column
// is on another page, which a CPU cannot prefetch. The strips fill rows of STRIP_TEXELS in the texture without padding,
// which keeps a picture of 8192 x 4320 below the largest texture height. A GPU stores its textures in blocks anyway.

uniform int picture_height;

// Number of a pixel in the order of the strips.
int index_in_strips(ivec2 at) {
    return (at.x / STRIP_COLUMNS * picture_height + at.y) * STRIP_COLUMNS + at.x % STRIP_COLUMNS;
}

// Position of a pixel in the texture.
ivec2 in_strips(ivec2 at) {
#ifdef STRIPS
    int texel = index_in_strips(at);
    return ivec2(texel % STRIP_TEXELS, texel / STRIP_TEXELS);
#else
    return at;
#endif
}

// Index of a pixel in a buffer of floats: in strips, or in blocks of 2 x 4 pixels, the 32 bytes that a GPU moves at
// once.
int index_in_buffer(ivec2 at) {
#ifdef STRIPS
    return index_in_strips(at);
#else
    int block = (at.x >> 1) * ((picture_height + 3) >> 2) + (at.y >> 2);
    return 8 * block + 2 * (at.y & 3) + (at.x & 1);
#endif
}

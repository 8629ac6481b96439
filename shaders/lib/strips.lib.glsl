// Storage position of a pixel in a picture that rows write and columns read.
//
// With STRIPS, strips of 8 columns are stored one after the other, row by row, so that a CPU reads 8
// columns, and writes 8 rows, from consecutive memory. In plain row order each step down a column is on
// another page, which a CPU cannot prefetch. The strips fill rows of STRIP_TEXELS in the texture, each
// strip going on right after the one before it, so that nothing is padded and a picture of 8192 x 4320
// stays below the largest texture height. A GPU stores its textures in blocks anyway.

uniform int picture_height;

ivec2 in_strips(ivec2 at) {
#ifdef STRIPS
    int row = at.x / STRIP_COLUMNS * picture_height + at.y;
    int texel = row * STRIP_COLUMNS + at.x % STRIP_COLUMNS;
    return ivec2(texel % STRIP_TEXELS, texel / STRIP_TEXELS);
#else
    return at;
#endif
}

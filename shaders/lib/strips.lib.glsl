// Storage position of a pixel in a picture that rows write and columns read.
//
// With STRIPS, strips of 8 columns are stored one after the other, row by row, so that a CPU reads 8
// columns, and writes 8 rows, from consecutive memory. In plain row order each step down a column is on
// another page, which a CPU cannot prefetch. 512 rows of a strip (4096 pixels) are folded into one row
// of the texture; with fewer, a picture of 8192 x 4320 would exceed the largest texture height.
// A GPU stores its textures in blocks anyway.

uniform int picture_height;

ivec2 in_strips(ivec2 at) {
#ifdef STRIPS
    int folds = (picture_height + STRIP_FOLD - 1) / STRIP_FOLD;
    int strip = at.x / STRIP_COLUMNS, fold = at.y / STRIP_FOLD;
    return ivec2((at.y % STRIP_FOLD) * STRIP_COLUMNS + at.x % STRIP_COLUMNS, strip * folds + fold);
#else
    return at;
#endif
}

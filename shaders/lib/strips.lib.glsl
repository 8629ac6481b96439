// Where a pixel lies in a picture that rows write and columns read.
//
// With STRIPS, strips of 8 columns lie one after the other, row by row: what a processor reads of 8
// columns then follows each other in memory, and so does what it writes of 8 rows. As the picture
// itself lies, each step down a column is another page, too far for a processor to fetch ahead.
// The texture is folded to 512 rows of a strip, which is 4096 pixels, in one of its own: unfolded, or
// folded to less, a picture of 8192 x 4320 would be higher than a texture may be.
// A GPU keeps its textures in blocks by itself.

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

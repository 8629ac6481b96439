// Marks of a listed pixel, in bits that no place in a picture needs (lib/pixel_list.lib.glsl).

#define MARK_FIRST 0x8000u      // the first hidden pixel of its block of 2 x 2: it tells the block's cost
#define MARK_WHOLE 0x80000000u  // its guess is that of the whole block

#define PLACE_MASK 0x7fff  // a place without its mark

// Numbers of the surfaces of lib/part_surfaces.lib.glsl: first the fragments of the lists, then the visible surfaces of
// the pixels of the picture, and with ALL_DEPTHS then the nearer surface that is mixed into each pixel.
//
// With ALL_DEPTHS the views show every surface, and without it only what is behind the focus.

#include "lib/part_surfaces.lib.glsl"  // coc_tx

uniform uint front_first;   // number of the first pixel of the picture: the number of fragments

// The number of the visible surface of a pixel.
uint front_index(ivec2 at) { return front_first + uint(at.y * textureSize(coc_tx, 0).x + at.x); }

#ifdef ALL_DEPTHS
// Number of the nearer surface that is mixed into a far edge pixel.
uint mixed_index(ivec2 at) { return front_index(at) + uint(textureSize(coc_tx, 0).x * textureSize(coc_tx, 0).y); }
#endif

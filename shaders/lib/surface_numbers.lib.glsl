// Numbers of the surfaces of lib/part_surfaces.lib.glsl: first the fragments of the lists, and then the pixels of the
// picture.
//
// With ALL_DEPTHS the views show every surface, and without it only what is behind the focus. Pixels of silhouettes are
// then taken apart, because their mixed colors would stay as specks where a near edge was: part_pixels.comp.glsl has
// written the surfaces of each pixel. The nearer surface of a far edge (lib/kind.lib.glsl) has a number too, after all
// pixels.
//
// Inputs
//   color_tx   without ALL_DEPTHS: rgb of the picture
//   lib/pixel_surface.lib.glsl   with ALL_DEPTHS: the surfaces of the pixels

#include "lib/part_surfaces.lib.glsl"  // coc_tx, Fragment, fragment_of
#ifdef ALL_DEPTHS
#include "lib/pixel_surface.lib.glsl"  // pixel_surface
#else
uniform sampler2D color_tx;
#endif
uniform uint front_first;   // number of the first pixel of the picture: the number of fragments

// The number of the visible surface of a pixel.
uint front_index(ivec2 at) { return front_first + uint(at.y * textureSize(coc_tx, 0).x + at.x); }

#ifdef ALL_DEPTHS
// Number of the nearer surface that is mixed into a far edge pixel.
uint mixed_index(ivec2 at) { return front_index(at) + uint(textureSize(coc_tx, 0).x * textureSize(coc_tx, 0).y); }
#endif

// The surface with this number: a fragment of a list, or the visible surface of a pixel.
Fragment surface_number(uint number) {
    if (number < front_first) return fragment_of(number);
#ifdef ALL_DEPTHS
    return pixel_surface(number - front_first);
#else
    int pixel = int(number - front_first), across = textureSize(coc_tx, 0).x;
    ivec2 at = ivec2(pixel % across, pixel / across);
    return Fragment(texelFetch(color_tx, at, 0).rgb, 1.0, texelFetch(coc_tx, at, 0).r);
#endif
}

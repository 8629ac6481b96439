// The surfaces that the parts of the lens see: fragments of lists, and the visible surface of pixels whose list does not
// begin with it. Both have numbers: first the fragments, then the pixels of the picture.
//
// With ALL_DEPTHS the views show every surface, and without it only what is behind the focus. Pixels of silhouettes are
// then taken apart, because their mixed colors would stay as specks where a near edge was: part_pixels.comp.glsl has
// written the surfaces of each pixel. The nearer surface of a far rim (lib/kind.lib.glsl) has a number too, after all
// pixels.
//
// Inputs
//   the fragment lists (lib/fragment_list.lib.glsl)
//   coc_tx     signed coc of the visible surface, pixels
//   color_tx   rgb of the picture, without ALL_DEPTHS
//   pixel_surface_buf   ALL_DEPTHS: the surfaces of part_pixels.comp.glsl

#include "lib/fragment_list.lib.glsl"

uniform sampler2D coc_tx;
#ifdef ALL_DEPTHS
#include "lib/pixel_surface.lib.glsl"
#else
uniform sampler2D color_tx;
#endif
uniform float least_px;     // coc from which the views show a surface
uniform uint front_first;   // number of the first pixel of the picture: the number of fragments

// The number of the visible surface of a pixel.
uint front_index(ivec2 at) { return front_first + uint(at.y * textureSize(coc_tx, 0).x + at.x); }

#ifdef ALL_DEPTHS
// Number of the nearer surface that is mixed into a far rim pixel.
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

#define SAME_SURFACE 1.03  // relative distance within which surfaces add up to one
#define COVERING 0.9          // share of a pixel from which a surface covers it

// Dioptres of a surface with this coc; at least 0.
float dioptres_of(float coc) { return max((coc - fragment_line.x) / fragment_line.y, 0.0); }

#define LEAST_COVER 0.5    // coverage above which a fragment is the first surface of a pixel

// Coc, in pixels, of the first surface along the ray of a pixel that the views show; -1 for none.
float first_coc_at(ivec2 at) {
    at = clamp(at, ivec2(0), textureSize(coc_tx, 0) - 1);
    List list = list_at(at);
    float coc = texelFetch(coc_tx, at, 0).r;
    if (!list.has_front && coc > least_px) return coc;
    for (uint i = list.first; i < list.end; ++i) {
        Fragment fragment = fragment_of(i);
        if (fragment.coc > least_px && fragment.cover > LEAST_COVER) return fragment.coc;
    }
    return -1.0;
}

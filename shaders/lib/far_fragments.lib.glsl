// The surfaces behind the focus: fragments of lists, and pixels of the picture whose list does not begin with
// the visible surface. Both are numbered: first the fragments, then the pixels.

#include "lib/fragment_list.lib.glsl"

uniform sampler2D color_tx;
uniform sampler2D coc_tx;
uniform float least_px;     // a surface with a smaller coc is not behind the focus
uniform uint front_first;   // index of the first pixel of the picture, after all fragments

uint front_index(ivec2 at) { return front_first + uint(at.y * textureSize(coc_tx, 0).x + at.x); }

// A pixel of the picture as a fragment.
Fragment front_at(ivec2 at) { return Fragment(texelFetch(color_tx, at, 0).rgb, 1.0, texelFetch(coc_tx, at, 0).r); }

// The surface with this index: a fragment of a list, or a pixel of the picture.
Fragment surface_number(uint number) {
    if (number < front_first) return fragment_of(number);
    int pixel = int(number - front_first), across = textureSize(coc_tx, 0).x;
    return front_at(ivec2(pixel % across, pixel / across));
}

#define SAME_SURFACE 1.03  // relative distance within which surfaces add up to one
#define WHOLE 0.9          // share of a pixel from which a surface covers it

float dioptres_of(float coc) { return max((coc - fragment_line.x) / fragment_line.y, 0.0); }

#define LEAST_COVER 0.5    // coverage above which a fragment is the first surface of a pixel

// Coc of the first surface behind the focus along a pixel's ray; -1 for none.
float far_coc_at(ivec2 at) {
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

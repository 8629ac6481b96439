// The surfaces that the parts of the lens see along the ray of a pixel: fragments of lists, and the visible surface of
// pixels whose list does not begin with it. lib/surface_numbers.lib.glsl gives them numbers.
//
// Inputs
//   the fragment lists (lib/fragment_list.lib.glsl)
//   coc_tx     signed coc of the visible surface, pixels

#include "lib/fragment_list.lib.glsl"  // List, list_at, fragment_of, Fragment

uniform sampler2D coc_tx;
uniform float least_px;     // coc from which the views show a surface

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

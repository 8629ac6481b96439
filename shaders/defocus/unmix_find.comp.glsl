// Finds the pixels on both sides of each silhouette. Anti-aliasing has mixed the colors of two surfaces there, but
// depth is a single sample.
//
// Words (lib/kind.lib.glsl): at a silhouette, a far edge pixel is one whose depth sample hit the far surface while the
// color of the nearer surface is mixed in; a near edge pixel is one whose sample hit the near surface while the color
// of the farther one shines through. Each of the two surfaces in such a pixel has its own color, coverage (share of the
// pixel) and coc (signed circle of confusion, diameter in pixels, negative in front of the focus).
//
// Inputs
//   coc_tx        r coc
//   with LISTS: fragment lists (lib/fragment_list.lib.glsl)
// Outputs
//   out_kind_img  r the kind, g the coc of the nearest surface in the pixel; with LISTS b a coc just in front of its list
//   two lists     the first list receives the far edges, the second one the near edges (lib/two_lists.lib.glsl)

#include "lib/focus_offset.lib.glsl"  // for lib/fragment_list.lib.glsl
#ifdef LISTS
#include "lib/fragment_list.lib.glsl"  // List, list_at, fragment_of
#endif
#include "lib/bit_search.lib.glsl"  // lowest_bit
#include "lib/silhouette.lib.glsl"  // set_center, neighbor, coc_at, is_in_front, coc_tx, UNMIXED, FAR_EDGE ...
#include "lib/two_lists.lib.glsl"  // append_word

layout(local_size_x = PIXEL_GROUP, local_size_y = PIXEL_GROUP) in;

uniform int first_row;  // first row of the band (render/defocus/pixel_list.py)

#ifdef LISTS
layout(rgba16f) uniform writeonly image2D out_kind_img;
uniform bool is_measured;  // the lists hold the measured coverage of every silhouette

// Returns those bits of `neighbors` whose pixels have all their surfaces in lists; all bits if this pixel has. The
// loop is a `do ... while`, which costs less on Mesa's llvmpipe (shaders/README.md).
uint listed_of(ivec2 at, uint neighbors) {
    if (is_measured || list_at(at).has_front) return neighbors;
    uint listed = 0u;
    do {
        int k = lowest_bit(neighbors | 1u << 9);  // 9, a bit that no neighbor has, if none is left
        listed |= uint(list_at(neighbor(at, k)).has_front) << k;
        neighbors &= neighbors - 1u;
    } while (neighbors != 0u);
    return listed;
}

#define HALF_STEP 0.001  // relative: at least the rounding error of a half float

// Writes the kind of a pixel, the coc of its nearest surface, and a coc in front of its list that a half float does not
// round into the list.
void store(ivec2 at, float kind, float nearest) {
    List list = list_at(at);
    float coc = list.first < list.end ? fragment_of(list.first).coc : NO_LIST_PX;
    float no_more = min(coc - HALF_STEP * abs(coc), NO_LIST_PX);
    imageStore(out_kind_img, at, vec4(list.has_front ? LISTED : kind, nearest, no_more, 0.0));
}
#else
layout(rg16f) uniform writeonly image2D out_kind_img;
uint listed_of(ivec2 at, uint neighbors) { return 0u; }  // without lists, no pixel is listed
void store(ivec2 at, float kind, float nearest) { imageStore(out_kind_img, at, vec4(kind, nearest, 0.0, 0.0)); }
#endif

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy) + ivec2(0, first_row);
    if (any(greaterThanEqual(at, textureSize(coc_tx, 0)))) return;
    set_center(at);
    float coc = coc_at(at), nearest = coc;
    uint nearer = 0u, farther = 0u;  // bit k is set if neighbor k is in front of this pixel, or behind it
    for (int k = 0; k < 9; ++k) {
        float other = coc_at(neighbor(at, k));
        nearer |= uint(is_in_front(other, coc)) << k;
        if (is_in_front(other, coc)) nearest = min(nearest, other);
        farther |= uint(is_in_front(coc, other)) << k;
    }
    uint listed = listed_of(at, nearer | farther);  // a silhouette between listed surfaces needs no unmixing
    float kind = (nearer & ~listed) != 0u ? FAR_EDGE : (farther & ~listed) != 0u ? NEAR_EDGE : UNMIXED;
    if (kind != UNMIXED) append_word(kind == FAR_EDGE, uint(at.y) << 16 | uint(at.x), 1);
    store(at, kind, clamp(kind == FAR_EDGE ? nearest : coc, -NO_LIST_PX, NO_LIST_PX));
}

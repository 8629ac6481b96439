// Finds the color of each near edge pixel without the background: from its surface beside the pixel, or, with LISTS,
// from the known surface behind it. unmix_near.comp.glsl uses this color to split the pixel.
//
// Words (lib/kind.lib.glsl): at a silhouette, a far edge pixel is one whose depth sample hit the far surface while the
// color of the nearer surface is mixed in; a near edge pixel is one whose sample hit the near surface while the color
// of the farther one shines through. Each of the two surfaces in such a pixel has its own color, coverage (share of the
// pixel) and coc (signed circle of confusion, diameter in pixels, negative in front of the focus).
//
// Inputs
//   color_tx, coc_tx, kind_tx   color, coc and kind of each pixel
//   two lists     the first has all far edge pixels, the second all near edge pixels
//   with LISTS: fragment lists, which may know what lies behind
// Outputs (near edge only; they hold until unmix_near.comp.glsl replaces them)
//   out_far_img   rgb own color, a OWN_FOUND; a 0 if no color was found
//   out_near_img  rgb own color less the own color as out_far_img stores it in half floats (the rounding error)
//   pixel list    the edge pixels without a color, which may be those of hair (unmix_thin.comp.glsl)

#include "lib/two_lists.lib.glsl"  // FOR_EACH_IN_SECOND, pixel_of_word, PIXELS_PER_GROUP
#include "lib/pixel_list.lib.glsl"  // list_append
#include "lib/unmix.lib.glsl"  // HALF_MAX, OWN_FOUND, SPLIT_FROM_PX, color_at, unmix_near, own_outline ...
#ifdef LISTS
#include "lib/known_behind.lib.glsl"  // find_behind, Fragment
#endif

layout(local_size_x = PIXELS_PER_GROUP) in;

layout(rgba16f) uniform writeonly image2D out_far_img;
layout(rgba16f) uniform writeonly image2D out_near_img;

#ifdef LISTS
// Finds the own color of a pixel from the light behind it: a wire has no unmixed pixel to take it from. Returns false
// if that light is not known.
bool unmix_known_behind(ivec2 at, out vec3 color) {
    float coc = coc_at(at), coverage = own_outline(at, coc);
    Fragment behind;
    bool is_known = find_behind(at, coc, behind);
    color = max((color_at(at) - (1.0 - coverage) * behind.color) / coverage, 0.0);
    return is_known;
}
#endif

// Finds and writes the own color of a listed near edge pixel.
void find_own(uint word) {
    ivec2 at = pixel_of_word(word);
    set_center(at);
    vec3 own;
    bool is_found = unmix_near(at, own);
#ifdef LISTS
    if (!is_found) is_found = unmix_known_behind(at, own);
#endif
    if (!is_found && abs(coc_at(at)) > SPLIT_FROM_PX) list_append(at);
    own = min(own, HALF_MAX);
    // in_half: the color as a half float image stores it.
    vec3 in_half = vec3(unpackHalf2x16(packHalf2x16(own.rg)), unpackHalf2x16(packHalf2x16(own.bb)).x);
    imageStore(out_far_img, at, vec4(in_half, is_found ? OWN_FOUND : 0.0));
    imageStore(out_near_img, at, vec4(own - in_half, 0.0));
}

void main() { FOR_EACH_IN_SECOND(find_own) }

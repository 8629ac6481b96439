// Finds the color of each near rim pixel without the background, if its surface continues beside
// the pixel or the surface behind it is known.
//
// Inputs
//   color_tx, coc_tx, kind_tx, two lists    as fragments_find.comp.glsl leaves them
//   with LISTS: fragment lists, which may know what lies behind
// Outputs (near rim only, for the passes up to fragments_near.comp.glsl)
//   out_far_img   rgb own colour, a OWN_FOUND; 0 if there is none
//   out_near_img  rgb the rounding error of that color in half floats
//   thin list     the rims that may be those of hair

#include "lib/two_lists.lib.glsl"
#include "lib/pixel_list.lib.glsl"
#include "lib/rim.lib.glsl"
#ifdef LISTS
#include "lib/known_behind.lib.glsl"
#endif

layout(local_size_x = PIXELS_PER_GROUP) in;

layout(rgba16f) uniform writeonly image2D out_far_img;
layout(rgba16f) uniform writeonly image2D out_near_img;

#ifdef LISTS
// Finds the own color of a pixel if the light behind it is known, as for a wire, which has no
// unmixed pixel.
bool unmix_known_behind(ivec2 at, out vec3 color) {
    float coc = coc_at(at), coverage = own_outline(at, coc);
    Fragment behind;
    bool is_known = find_behind(at, coc, behind);
    color = max((color_at(at) - (1.0 - coverage) * behind.color) / coverage, 0.0);
    return is_known;
}
#endif

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
    vec3 in_half = vec3(unpackHalf2x16(packHalf2x16(own.rg)), unpackHalf2x16(packHalf2x16(own.bb)).x);
    imageStore(out_far_img, at, vec4(in_half, is_found ? OWN_FOUND : 0.0));
    imageStore(out_near_img, at, vec4(own - in_half, 0.0));
}

void main() { FOR_EACH_IN_BACK(find_own) }

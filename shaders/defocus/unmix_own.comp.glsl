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
//   out_far_img   rgb own color, a OWN_FOUND or OWN_BY_OUTLINE (lib/unmix.lib.glsl), 0 if no color was found
//   out_near_img  rgb own color less the own color as out_far_img stores it in half floats (the rounding error)
//   pixel list    the edge pixels without a color, which may be those of hair (unmix_thin.comp.glsl)

#include "lib/two_lists.lib.glsl"  // FOR_EACH_IN_SECOND, pixel_of_word, PIXELS_PER_GROUP
#include "lib/pixel_list.lib.glsl"  // list_append
#include "lib/unmix.lib.glsl"  // HALF_MAX, OWN_FOUND, OWN_BY_OUTLINE, color_at, unmix_near ...
#include "lib/outline.lib.glsl"  // outline_share
#ifdef LISTS
#include "lib/known_behind.lib.glsl"  // find_behind, Fragment
#include "lib/tone.lib.glsl"  // mean_of
#endif

layout(local_size_x = PIXELS_PER_GROUP) in;

layout(rgba16f) uniform writeonly image2D out_far_img;
layout(rgba16f) uniform writeonly image2D out_near_img;

#ifdef LISTS
#define OWN_SIDE 5  // side of the square that is searched for the color of hair, pixels

// The darkest color of the same surface around a pixel.
vec3 darkest_around(ivec2 at, float coc) {
    vec3 darkest = color_at(at);
    for (int i = 0; i < OWN_SIDE * OWN_SIDE; ++i) {
        ivec2 p = inside(at + ivec2(i % OWN_SIDE, i / OWN_SIDE) - OWN_SIDE / 2);
        vec3 color = color_at(p);
        if (is_same_surface(coc, coc_at(p)) && mean_of(color) < mean_of(darkest)) darkest = color;
    }
    return darkest;
}

// Finds the own color of a pixel from the light behind it: a wire has no unmixed pixel to take it from. Returns 0 if that
// light is not known, else OWN_BY_OUTLINE, plus up to 1 where hair is in front of something much brighter. Hair may cover
// less of the pixel than its outline tells, and the rest of the light would remain in its color.
float unmix_known_behind(ivec2 at, out vec3 color) {
    float coc = coc_at(at), coverage = outline_share(at, coc, false);
    Fragment behind;
    bool is_known = find_behind(at, coc, behind);
    color = max((color_at(at) - (1.0 - coverage) * behind.color) / coverage, 0.0);
    if (!is_known) return 0.0;
    vec3 darkest = darkest_around(at, coc);
    float ratio = mean_of(behind.color) / max(mean_of(darkest), 1e-3);
    // Twice the ratios of hair before an unknown surface: wires before a bright wall, known, lost by less (FLIP .0509, .0515).
    float thin = smoothstep(2.0 * BRIGHTER_FROM, 2.0 * BRIGHTER_FULL, ratio);
    color = mix(color, darkest, thin);
    return OWN_BY_OUTLINE + thin;
}
#endif

// Finds and writes the own color of a listed near edge pixel.
void find_own(uint word) {
    ivec2 at = pixel_of_word(word);
    set_center(at);
    vec3 own;
    float found = unmix_near(at, own) ? OWN_FOUND : 0.0;
#ifdef LISTS
    if (found == 0.0) found = unmix_known_behind(at, own);
#endif
    if (found == 0.0) list_append(at);
    own = min(own, HALF_MAX);
    // in_half: the color as a half float image stores it.
    vec3 in_half = vec3(unpackHalf2x16(packHalf2x16(own.rg)), unpackHalf2x16(packHalf2x16(own.bb)).x);
    imageStore(out_far_img, at, vec4(in_half, found));
    imageStore(out_near_img, at, vec4(own - in_half, 0.0));
}

void main() { FOR_EACH_IN_SECOND(find_own) }

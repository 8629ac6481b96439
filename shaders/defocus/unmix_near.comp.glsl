// Removes from each near edge pixel the light that shines through it from behind.
//
// Words (lib/kind.lib.glsl): at a silhouette, a far edge pixel is one whose depth sample hit the far surface while the
// color of the nearer surface is mixed in; a near edge pixel is one whose sample hit the near surface while the color
// of the farther one shines through. Each of the two surfaces in such a pixel has its own color, coverage (share of the
// pixel) and coc (signed circle of confusion, diameter in pixels, negative in front of the focus).
//
// Inputs
//   color_tx, coc_tx, kind_tx   color, coc and kind of each pixel
//   two lists     the first has all far edge pixels, the second all near edge pixels
//   with LISTS: fragment lists, which may know what shines through
// In and out; far edge pixels are only read, near edge pixels read and written
//   far_img       far edge, before: rgb of the far surface (unmix_far.comp.glsl)
//                 near edge, before: rgb own color, a OWN_FOUND or more if there is one (unmix_own.comp.glsl)
//                 near edge, after: rgb own color, without the light from behind, a its coverage
//   near_img      near edge, before: rgb rounding error of the own color, to be added to it
//                 near edge, after: rgb 0, a coc of the surface that shines through

#include "lib/two_lists.lib.glsl"  // FOR_EACH_IN_SECOND, pixel_of_word, PIXELS_PER_GROUP
#include "lib/unmix.lib.glsl"  // HALF_MAX, OWN_FOUND, OWN_BY_OUTLINE, color_at, kind_at, unmix_share ...
#include "lib/outline.lib.glsl"  // outline_share
#ifdef LISTS
#include "lib/known_behind.lib.glsl"  // find_behind, Fragment
#endif

layout(local_size_x = PIXELS_PER_GROUP) in;

layout(rgba16f) uniform image2D far_img;
layout(rgba16f) uniform image2D near_img;

#define LEAST_COVERAGE 0.5  // least coverage: depth is sampled at the pixel's center and hit the near surface

// Color of a farther neighbor, from which the near surface has been removed.
vec3 far_color(ivec2 at) {
    return kind_at(at) == FAR_EDGE ? imageLoad(far_img, at).rgb : color_at(at);
}

// Splits a listed near edge pixel: its own color without the light from behind, and its coverage.
void split_near(uint word) {
    ivec2 at = pixel_of_word(word);
    set_center(at);
    float coc = coc_at(at);
    vec4 unmixed = imageLoad(far_img, at);
    // x is the mixed color of the pixel; the rounding error in near_img restores the own color in full.
    vec3 x = color_at(at), near = unmixed.rgb + imageLoad(near_img, at).rgb;
    if (unmixed.a < OWN_FOUND) return;  // unmix_thin.comp.glsl splits it
    vec4 far = vec4(0.0);  // mean of the farther neighbors: rgb, a = coc
    vec3 squares = vec3(0.0);
    float count = 0.0;
    for (int k = 0; k < 9; ++k) {
        ivec2 p = neighbor(at, k);
        float other = coc_at(p);
        if (!is_in_front(coc, other)) continue;
        vec3 color = far_color(p);
        far += vec4(color, other);
        squares += color * color;
        count += 1.0;
    }
    far /= count;
    float variance = variance_of(far.rgb, squares / count), blur_px = coc;
#ifdef LISTS
    Fragment behind;
    if (find_behind(at, coc, behind)) {
        far = vec4(behind.color, behind.coc);
        variance = 0.0;
        if (unmixed.a >= OWN_BY_OUTLINE) blur_px = max(abs(coc), abs(behind.coc));
    }
#endif
    float coverage = coverage_of(x, near, far.rgb, variance, outline_share(at, coc, false));
    float least = mix(LEAST_COVERAGE, LEAST_THIN_COVERAGE, max(unmixed.a - OWN_BY_OUTLINE, 0.0));
    coverage = clamp(coverage, least, 1.0);
    coverage = 1.0 - unmix_share(blur_px) * (1.0 - coverage);
    vec3 own = max((x - (1.0 - coverage) * far.rgb) / coverage, 0.0);
    imageStore(far_img, at, vec4(min(own, HALF_MAX), coverage));
    imageStore(near_img, at, vec4(vec3(0.0), far.a));
}

void main() { FOR_EACH_IN_SECOND(split_near) }

// Splits the edges of hair and other things so thin that no pixel certainly shows one surface alone. In front of
// something much brighter, lib/thin.lib.glsl finds both colors and the coverage; they count in proportion to their
// confidence. Otherwise a far edge stays as it is, and a near edge covers what its outline does.
//
// Words (lib/kind.lib.glsl): at a silhouette, a far edge pixel is one whose depth sample hit the far surface while the
// color of the nearer surface is mixed in; a near edge pixel is one whose sample hit the near surface while the color
// of the farther one shines through. Each of the two surfaces in such a pixel has its own color, coverage (share of the
// pixel) and coc (signed circle of confusion, diameter in pixels, negative in front of the focus).
//
// Inputs
//   color_tx, coc_tx, kind_tx   color, coc and kind of each pixel
//   with LISTS: fragment lists, which know what is behind hair
//   pixel list    the edge pixels that may be those of hair (unmix_own.comp.glsl, unmix_far.comp.glsl)
// In and out; far edge pixels are read and written, near edge pixels only written
//   far_img, near_img    as unmix_far.comp.glsl and unmix_near.comp.glsl write them:
//     far edge    far_img rgb the far surface, a coverage of the near one; near_img rgb the near surface, a its coc
//     near edge   far_img rgb the near surface, a its coverage; near_img rgb 0, a coc of the surface behind

#include "lib/focus_offset.lib.glsl"  // for lib/fragment_list.lib.glsl
#include "lib/pixel_list.lib.glsl"  // FOR_EACH_LISTED, PIXELS_PER_GROUP
#include "lib/unmix.lib.glsl"  // HALF_MAX, color_at, kind_at, unmix_share, FAR_EDGE, set_center, neighbor ...
#include "lib/outline.lib.glsl"  // outline_share
#ifdef LISTS
#include "lib/known_behind.lib.glsl"  // for lib/thin.lib.glsl
#endif
#include "lib/tone.lib.glsl"  // for lib/thin.lib.glsl
#include "lib/bit_search.lib.glsl"  // for lib/thin.lib.glsl
#include "lib/thin.lib.glsl"  // Mixture, is_beside_thin, thin_mixture

layout(local_size_x = PIXELS_PER_GROUP) in;

layout(rgba16f) uniform image2D far_img;
layout(rgba16f) uniform image2D near_img;

#define LEAST_SEEN 0.7           // visible share of a far surface behind hair from which it keeps its detail

// Mean light of the farther surfaces beside a near edge pixel.
vec3 light_beside(ivec2 at, float coc) {
    vec4 sum = vec4(0.0);
    for (int k = 0; k < 9; ++k) {
        ivec2 p = neighbor(at, k);
        if (is_in_front(coc, coc_at(p))) sum += vec4(color_at(p), 1.0);
    }
    return sum.rgb / sum.a;
}

// Splits a listed edge pixel, far or near.
void split_thin(ivec2 at) {
    set_center(at);
    vec3 x = color_at(at);
    float coc = coc_at(at), behind = coc;  // behind: coc of the surface behind the hair
    bool is_far = kind_at(at) == FAR_EDGE;
    for (int k = 0; k < 9 && !is_far; ++k) behind = max(behind, coc_at(neighbor(at, k)));
    Mixture mixed = thin_mixture(at, behind, !is_far || is_beside_thin(at, coc));
    vec4 far, near;
    if (is_far) {
        float visible_share = 1.0 - mixed.coverage;
        if (visible_share > LEAST_SEEN) mixed.far = max(x - mixed.coverage * mixed.near, 0.0) / visible_share;
        far = mix(imageLoad(far_img, at), vec4(min(mixed.far, HALF_MAX), mixed.coverage), mixed.sure);
        near = imageLoad(near_img, at);
        near.rgb = mix(near.rgb, min(mixed.near, HALF_MAX), mixed.sure);
    } else {
        // Unlike a far edge, the pixel stores no color of the surface behind, which its own layer guesses; near_img has
        // only the coc of that surface. Where colors do not tell how much hair covers, its outline does.
        float coverage = mix(outline_share(at, coc, false), max(mixed.coverage, LEAST_THIN_COVERAGE), mixed.sure);
        coverage = 1.0 - unmix_share(max(abs(coc), abs(behind))) * (1.0 - coverage);
        vec3 through = mix(light_beside(at, coc), mixed.far, mixed.sure);
        vec3 own = max((x - (1.0 - coverage) * through) / coverage, 0.0);
        far = vec4(min(own, HALF_MAX), coverage);
        near = vec4(vec3(0.0), coverage < 1.0 ? behind : coc);
    }
    imageStore(far_img, at, far);
    imageStore(near_img, at, near);
}

void main() { FOR_EACH_LISTED(split_thin) }

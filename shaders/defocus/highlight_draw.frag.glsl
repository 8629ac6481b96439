// Draws the disc of a highlight where the lens sees the highlight; with LISTS, also behind partly transparent
// fragments.
//
// Inputs (those from highlight_draw.vert.glsl are declared below)
//   pixel list        the hidden share of the highlight at the nodes of its disc (highlight_shadow.comp.glsl)
//   with LARGE: those of lib/highlight_rays.lib.glsl
//   edges_tx          r the words of edge pixels (lib/edge_word.lib.glsl)
//   near_tx           a coc of the near surface of edge pixels (unmix_far.comp.glsl)
//   cutout_tx, cutout_coc_tx   a share of the pixel and r coc of the cutout, if has_cutout (cutout_over.comp.glsl)
//   with LISTS: fragment lists (lib/fragment_list.lib.glsl)
// Output
//   out_light         rgb light of the highlight in the pixel, to be added to the picture; a 0

#define SOFT_RIM
#include "lib/aperture.lib.glsl"  // Cover, most_of
#ifdef LISTS
#include "lib/fragment_list.lib.glsl"  // List, list_at, fragment_of, Fragment
#endif
#include "lib/edge_word.lib.glsl"  // is_far_edge, edge_cover
#include "lib/highlights.lib.glsl"  // MARGIN_PX, SHARP_PX, BLURRED_PX
#include "lib/pixel_cover.lib.glsl"  // pixel_coverage
#include "lib/highlight_nodes.lib.glsl"  // coc_of, share_between_nodes
#ifdef LARGE
#include "lib/highlight_rays.lib.glsl"  // mean_hidden_share, edges_tx
#else
uniform sampler2D edges_tx;
#endif
uniform sampler2D near_tx;

flat in vec4 disc;  // center x, y in pixels; signed coc; half the width of the rim's ramp
flat in vec4 light;  // rgb of a pixel wholly inside; a least signed coc that a ray may meet
flat in vec4 nodes;  // where rays are traced

uniform float enlarged;    // pixels of the target across a pixel of the picture: above 1 discs have round rims
uniform bool has_cutout;   // a part stays sharp (cutout_over.comp.glsl), and hides highlights that are not nearer
uniform sampler2D cutout_tx;
uniform sampler2D cutout_coc_tx;

out vec4 out_light;

// Share of the highlight's light that nearer fragments in the pixel itself let through: an anti-aliased silhouette in
// focus lets light through where its near surface does not cover.
float visible_share_at(ivec2 at, float coc) {
#ifdef LISTS
    List list = list_at(at);
    float uncovered = 1.0;
    for (uint i = list.first; i < list.end && list.has_front; ++i) {
        Fragment fragment = fragment_of(i);
        if (fragment.coc > coc - MARGIN_PX) break;
        uncovered *= 1.0 - fragment.cover * (1.0 - smoothstep(SHARP_PX, BLURRED_PX, abs(fragment.coc)));
    }
    if (list.has_front) return uncovered;
#endif
    uint word = floatBitsToUint(texelFetch(edges_tx, at, 0).r);
    float near_coc = texelFetch(near_tx, at, 0).a;
    if (!is_far_edge(word) || near_coc > coc - MARGIN_PX) return 1.0;
    return mix(1.0 - edge_cover(word), 1.0, smoothstep(SHARP_PX, BLURRED_PX, abs(near_coc)));
}

// The same at a position: smooth between pixels of the picture where the target has more pixels than the picture.
float visible_share(vec2 position, float coc) {
    vec2 high = fract(position - 0.5);
    ivec2 first = ivec2(floor(position - 0.5)), last = textureSize(edges_tx, 0) - 1;
    int pixels = high == vec2(0.0) ? 1 : 4;  // the position is the middle of a pixel: always, if none is enlarged
    float share = 0.0;
    for (int i = 0; i < pixels; ++i) {
        ivec2 corner = ivec2(i & 1, i >> 1);
        vec2 part = mix(1.0 - high, high, vec2(corner));
        share += part.x * part.y * visible_share_at(clamp(first + corner, ivec2(0), last), coc);
    }
    return share;
}

// Share of the pixel in which the sharp cutout hides the highlight. The condition does not begin with the uniform, which
// lavapipe of Mesa 22 would take as a reason to build the program anew for each draw and to never free it.
float cutout_cover(ivec2 at, float coc) {
    if (texelFetch(cutout_coc_tx, at, 0).r > coc || !has_cutout) return 0.0;
    return texelFetch(cutout_tx, at, 0).a;
}

// Share of the highlight that nearer surfaces hide from the points of the lens that a position in the disc stands for.
float hidden_share_at(vec2 position, float coc) {
#ifdef LARGE
    return mean_hidden_share(position, disc.xy, coc, disc.w, light.a);
#else
    return share_between_nodes(position, nodes);
#endif
}

#define PIXEL_RAMP_2 0.25  // square of the ramp of a disc of one pixel's light (highlight_sprites.comp.glsl)

// Half the width of the soft rim in pixels of the target, where a pixel of light is narrower.
float target_ramp(float ramp) {
    return sqrt(max(enlarged * enlarged * (ramp * ramp - PIXEL_RAMP_2), 0.0) + PIXEL_RAMP_2);
}

void main() {
    float coc = coc_of(disc), ramp = target_ramp(disc.w);
    vec2 position = gl_FragCoord.xy / enlarged;  // in pixels of the picture
    Cover inside = pixel_coverage(enlarged * (position - disc.xy), 0.5 * coc * enlarged, ramp, disc.xy);
    if (most_of(inside) > 0.0) inside *= 1.0 - cutout_cover(ivec2(position), coc);
    if (most_of(inside) > 0.0) inside *= visible_share(position, coc);
    if (most_of(inside) > 0.0) inside *= 1.0 - hidden_share_at(position, coc);
    if (most_of(inside) == 0.0) discard;
    out_light = vec4(inside * light.rgb, 0.0);
}

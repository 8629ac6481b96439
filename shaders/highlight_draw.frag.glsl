// Draws a highlight's disc where the lens sees it; with LISTS, also past partly transparent fragments.
// Each pixel of the disc is a point on the lens. The ray from there to the highlight crosses nearer
// depths at positions that move towards the pixel in proportion to the difference in coc; whatever is
// at that depth there hides the highlight. Surfaces nearer by less than a margin are ignored here;
// with LISTS, highlight_split has already accounted for them.

#include "lib/aperture.lib.glsl"
#ifdef LISTS
#include "lib/fragment_list.lib.glsl"
#endif
#include "lib/kind.lib.glsl"
#include "lib/pixel_cover.lib.glsl"

flat in vec4 place;  // centre x, y in pixels; signed coc; half the width of the rim's ramp
flat in vec3 light;

uniform sampler2D coc_tx;
uniform sampler2D kind_tx;
uniform sampler2D far_tx;
uniform sampler2D near_tx;
uniform float nearest_px;  // least signed coc in the picture

out vec4 out_light;

// Up to a coc of SHARP_PX a nearer fragment covers just its own pixel; from BLURRED_PX on, compositing
// its blurred layer does the hiding.
#define SHARP_PX 1.0
#define BLURRED_PX 4.0

#define STEPS 16
// A surface nearer by less than MARGIN_PX, or less than MARGIN_PART of the highlight's coc, belongs to
// the highlight.
#define MARGIN_PX 2.0
#define MARGIN_PART 0.1
// The refined lookup must meet the same surface: a coc within SAME_COC_PX, or within SAME_COC_PART of
// the difference to the highlight.
#define SAME_COC_PX 1.0
#define SAME_COC_PART 0.25

// The four pixels around a position, in textureGather order, and their bilinear weights. GPUs round
// the gather position, so gather at the corner shared by the four texels, to match the weights.
vec2 meeting_place(vec2 at) { return (floor(at - 0.5) + 1.0) / vec2(textureSize(coc_tx, 0)); }
vec4 cocs_around(vec2 at) { return textureGather(coc_tx, meeting_place(at)); }
float least_around(vec2 at) {
    vec4 cocs = cocs_around(at);
    return min(min(cocs.x, cocs.y), min(cocs.z, cocs.w));
}
vec4 weights_around(vec2 at) {
    vec2 high = fract(at - 0.5), low = 1.0 - high;
    return vec4(low.x * high.y, high.x * high.y, high.x * low.y, low.x * low.y);
}
bool is_outside(vec2 at) {
    return any(lessThan(at, vec2(0.0))) || any(greaterThan(at, vec2(textureSize(coc_tx, 0))));
}

#ifdef LISTS
// Share of a pixel covered by fragments nearer than `start`; 1 if it has no list of its own.
float cover_at(ivec2 at, float start) {
    ivec2 size = textureSize(coc_tx, 0);
    List list = list_at(clamp(at, ivec2(0), size - 1));
    float seen = list.has_front ? 1.0 : 0.0;
    for (uint i = list.first; i < list.end && seen > 0.0; ++i) {
        Fragment fragment = fragment_of(i);
        if (fragment.coc >= start) break;
        seen *= 1.0 - fragment.cover;
    }
    return 1.0 - seen;
}
vec4 covers_around(vec2 at, float start) {
    ivec2 low = ivec2(floor(at - 0.5));
    return vec4(cover_at(low + ivec2(0, 1), start), cover_at(low + 1, start),
                cover_at(low + ivec2(1, 0), start), cover_at(low, start));
}
vec4 kinds_around(vec2 at) { return textureGather(kind_tx, meeting_place(at)); }
ivec2 inside(vec2 at) { return clamp(ivec2(floor(at)), ivec2(0), textureSize(kind_tx, 0) - 1); }

// Share of a pixel covered by the listed surface at this coc.
float cover_of(ivec2 at, float coc, float same) {
    ivec2 size = textureSize(coc_tx, 0);
    List list = list_at(clamp(at, ivec2(0), size - 1));
    float seen = 1.0;
    for (uint i = list.first; i < list.end; ++i) {
        Fragment fragment = fragment_of(i);
        if (fragment.coc > coc + same) break;
        if (fragment.coc >= coc - same) seen *= 1.0 - fragment.cover;
    }
    return 1.0 - seen;
}
vec4 covers_of(vec2 at, float coc, float same) {
    ivec2 low = ivec2(floor(at - 0.5));
    return vec4(cover_of(low + ivec2(0, 1), coc, same), cover_of(low + 1, coc, same),
                cover_of(low + ivec2(1, 0), coc, same), cover_of(low, coc, same));
}

// Share hidden by listed surfaces near `level`: a ray may cross such a surface where the picture shows
// another, nearer one.
float listed_part(vec2 centre, vec2 per_px, float coc, float level, float step_px, float start) {
    List list = list_at(inside(centre + per_px * (coc - level)));
    float hidden = 0.0;
    for (uint i = list.first; i < list.end; ++i) {
        float met = fragment_of(i).coc;
        if (met >= start || met > level + step_px) break;
        if (met < level - step_px) continue;
        vec2 crossed = centre + per_px * (coc - met);
        vec4 covers = covers_of(crossed, met, max(SAME_COC_PX, SAME_COC_PART * (coc - met)));
        hidden = max(hidden, dot(covers, weights_around(crossed)));
    }
    return hidden;
}
#endif

// Weighted share of the four surrounding pixels that hides at the coc `met`.
vec4 hits_around(vec2 at, float coc, float met) {
    float same = max(SAME_COC_PX, SAME_COC_PART * (coc - met));
    return step(abs(cocs_around(at) - met), vec4(same));
}

// Share of the highlight hidden from this point of the lens, 0..1: smooth across an occluder's edge.
// Steps that meet something are noted and looked at last: a software rasteriser runs the whole body of
// a loop as soon as one of its invocations needs part of it.
float hidden_part(vec2 at, vec2 centre, float coc) {
    float start = coc - max(MARGIN_PX, MARGIN_PART * abs(coc));
    float step_px = (start - nearest_px) / float(STEPS);
    vec2 per_px = (at - centre) / coc;
    float hidden = 0.0;
    uint shown = 0u, listed = 0u, mixed = 0u;
    for (int k = 0; k < STEPS && step_px > 0.0; ++k) {
        float level = start - (float(k) + 0.5) * step_px;
        vec2 crossed = centre + per_px * (coc - level);
        if (is_outside(crossed)) break;
#ifdef LISTS
        if (texelFetch(kind_tx, inside(crossed), 0).g < min(start, level + step_px)) listed |= 1u << k;
#endif
        float met = least_around(crossed);
        if (met < start && abs(met - level) <= step_px) shown |= 1u << k;
    }
    for (; shown != 0u && hidden < 1.0; shown &= shown - 1u) {
        float level = start - (float(findLSB(shown)) + 0.5) * step_px;
        float met = least_around(centre + per_px * (coc - level));
        vec2 crossed = centre + per_px * (coc - met);
        float hit = dot(hits_around(crossed, coc, met), weights_around(crossed));
#ifdef LISTS
        if (any(equal(kinds_around(crossed), vec4(LISTED)))) {
            mixed |= shown & -shown;
            hit = 0.0;
        }
#endif
        hidden = max(hidden, hit);
    }
#ifdef LISTS
    for (; listed != 0u && hidden < 1.0; listed &= listed - 1u) {
        float level = start - (float(findLSB(listed)) + 0.5) * step_px;
        hidden = max(hidden, listed_part(centre, per_px, coc, level, step_px, start));
    }
    for (; mixed != 0u && hidden < 1.0; mixed &= mixed - 1u) {
        float level = start - (float(findLSB(mixed)) + 0.5) * step_px;
        float met = least_around(centre + per_px * (coc - level));
        vec2 crossed = centre + per_px * (coc - met);
        vec4 hits = hits_around(crossed, coc, met) * covers_around(crossed, start);
        hidden = max(hidden, dot(hits, weights_around(crossed)));
    }
#endif
    return hidden;
}

// An anti-aliased silhouette in focus lets light through where its near fragment does not cover.
float seen_at(ivec2 at, float coc) {
#ifdef LISTS
    List list = list_at(at);
    float seen = 1.0;
    for (uint i = list.first; i < list.end && list.has_front; ++i) {
        Fragment fragment = fragment_of(i);
        if (fragment.coc > coc - MARGIN_PX) break;
        seen *= 1.0 - fragment.cover * (1.0 - smoothstep(SHARP_PX, BLURRED_PX, abs(fragment.coc)));
    }
    if (list.has_front) return seen;
#endif
    float kind = texelFetch(kind_tx, at, 0).r;
    vec4 far = texelFetch(far_tx, at, 0);
    float near_coc = texelFetch(near_tx, at, 0).a;
    if (kind != FAR_RIM || near_coc > coc - MARGIN_PX) return 1.0;
    return mix(1.0 - far.a, 1.0, smoothstep(SHARP_PX, BLURRED_PX, abs(near_coc)));
}

void main() {
    float coc = place.z, ramp = place.w;
    if (abs(coc) < 1e-3) coc = 1e-3;
    Cover inside = pixel_coverage(gl_FragCoord.xy - place.xy, 0.5 * coc, ramp, place.xy);
    if (most_of(inside) > 0.0) inside *= seen_at(ivec2(gl_FragCoord.xy), coc);
    if (most_of(inside) > 0.0) inside *= 1.0 - hidden_part(gl_FragCoord.xy, place.xy, coc);
    if (most_of(inside) == 0.0) discard;
    out_light = vec4(inside * light, 0.0);
}

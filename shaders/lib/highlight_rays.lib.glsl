// The rays from the lens to a highlight, which tell how much of it is hidden.
//
// Each pixel of the disc is a point on the lens. The ray from there to the highlight crosses nearer depths at positions
// that move towards the pixel in proportion to the difference in coc (signed circle of confusion, diameter in pixels,
// negative in front of the focus). A surface at that depth and position hides the highlight. Surfaces nearer by less
// than a margin are ignored here; with LISTS, highlight_split.comp.glsl has already accounted for them.
//
// Inputs
//   coc_tx            r coc of the visible surface of each pixel
//   kind_tx           g coc of the nearest surface, b of the first listed fragment (lib/kind.lib.glsl)
//   ranges_tx         r least, g greatest coc of the surfaces of 2 x 2 pixels (highlight_ranges.comp.glsl)
//   edges_tx          r the words of edge pixels (lib/edge_word.lib.glsl)

#include "lib/aperture.lib.glsl"  // aperture_coverage, aperture_reach, most_of
#ifdef LISTS
#include "lib/fragment_list.lib.glsl"  // List, list_at, fragment_of, Fragment
#endif
#include "lib/bit_search.lib.glsl"  // lowest_bit
#include "lib/edge_word.lib.glsl"  // edge_covers, edge_cocs, FAR_BIT, LISTED_WORD
#include "lib/highlights.lib.glsl"  // margin_of, SHARP_PX, BLURRED_PX

uniform sampler2D coc_tx;
uniform sampler2D kind_tx;
uniform sampler2D ranges_tx;
uniform sampler2D edges_tx;
uniform float nearest_px;  // least signed coc in the picture

// A ray is tested in at most STEPS steps, of at least STEP_PX pixels each.
#define STEPS 16
#define STEP_PX 0.5
// A highlight is tested by a ray for each square of PX_A_RAY that the nearest surface moves by, and by RAYS_MOST at most.
// In a disc of few pixels, where all points of the lens reach each pixel, fewer are enough.
#define PX_A_RAY 8.0
#define RAYS_MOST 36.0
#define RAYS_OF_POINT 8.0  // at most, for a disc of coc 0
#define RAYS_A_PX 8.0  // rays added for each pixel of the coc
// Multiples of these fill a square evenly, without rows that a grating could match: they place the rays, and begin
// elsewhere for a highlight a pixel to the right or below.
#define SPREAD_RAYS vec2(0.75487767, 0.56984029)
#define SPREAD_X vec2(0.61803399, 0.32471796)
#define SPREAD_Y vec2(0.32471796, 0.61803399)
#define OPENING_PX 64.0  // size at which the opening is looked up for a ray, and half the width of its soft rim then
#define RIM_PX 2.0
#define LEAST_SHARE 0.001  // of a ray outside the opening: the mean of them counts where no ray is inside
// The refined lookup must meet the same surface: a coc within SAME_COC_PX, or within SAME_COC_SHARE of
// the difference to the highlight.
#define SAME_COC_PX 1.0
#define SAME_COC_SHARE 0.25
#define MAGNIFIED 1.5       // magnification of an edge from which its pixels count with their coverage
#define MAGNIFIED_FULL 3.0  // from here on with all of it

// Of the four pixels around a position: the coordinates to gather them at, their coc, the coc of the nearest surface that
// covers a part of each, that of all these which is closest to the coc `level`, their words, and their bilinear weights,
// in the order of textureGather. GPUs round the gather position; the corner shared by the four texels makes the gathered
// texels match the weights.
vec2 gather_position(vec2 at) { return (floor(at - 0.5) + 1.0) / vec2(textureSize(coc_tx, 0)); }
vec4 cocs_around(vec2 at) { return textureGather(coc_tx, gather_position(at)); }
vec4 nearest_around(vec2 at) { return textureGather(kind_tx, gather_position(at), 1); }
uvec4 words_around(vec2 at) { return floatBitsToUint(textureGather(edges_tx, gather_position(at))); }
vec4 closest(vec4 a, vec4 b, float level) {
    return mix(a, b, lessThan(abs(b - level), abs(a - level)));
}
float coc_around(vec2 at, float level) {
    vec4 cocs = closest(cocs_around(at), nearest_around(at), level), gaps = abs(cocs - level);
    float low = gaps.x < gaps.y ? cocs.x : cocs.y, high = gaps.z < gaps.w ? cocs.z : cocs.w;
    return abs(low - level) < abs(high - level) ? low : high;
}
vec4 weights_around(vec2 at) {
    vec2 high = fract(at - 0.5), low = 1.0 - high;
    return vec4(low.x * high.y, high.x * high.y, high.x * low.y, low.x * low.y);
}
// True if a position is outside the picture.
bool is_outside(vec2 at) {
    return any(lessThan(at, vec2(0.0))) || any(greaterThan(at, vec2(textureSize(coc_tx, 0))));
}

// The pixel at a position, or the nearest one inside the picture.
ivec2 inside(vec2 at) { return clamp(ivec2(floor(at)), ivec2(0), textureSize(kind_tx, 0) - 1); }

// The ray from a point of the lens to a highlight.
struct Ray {
    vec2 center, per_px;  // position of the highlight, and movement of the ray for each pixel of coc
    float coc;            // coc of the highlight
    float start;          // largest coc of a surface that hides the highlight; tests go from there to nearer ones
    float step_px;        // difference in coc between two tests for surfaces
};

// Position at which the ray crosses the depth of a coc.
vec2 crossing(Ray ray, float coc) { return ray.center + ray.per_px * (ray.coc - coc); }

// Difference in coc up to which a surface is the same as one met at the coc `met`.
float same_px(Ray ray, float met) { return max(SAME_COC_PX, SAME_COC_SHARE * (ray.coc - met)); }

// The coc in the middle of a step.
float level_at(Ray ray, int step) { return ray.start - (float(step) + 0.5) * ray.step_px; }

// The share of each of the four surrounding pixels that a surface at the coc `met` covers. Beside the edge of a nearer
// surface it is taken to go on behind that: otherwise light would pass in a line of specks. A disc magnifies the edge of
// what is only a little nearer than its highlight, by a factor of coc / (coc - met): there an edge pixel counts with its
// coverage, because whole pixels would end the disc in stairs. What hides the highlight behind a near edge pixel hides
// all of it.
vec4 hits_around(Ray ray, vec2 at, float met) {
    float same = met + same_px(ray, met), magnified = abs(ray.coc) / (ray.coc - met);
    uvec4 words = words_around(at);
    vec4 covers = edge_covers(words), others = edge_cocs(words);
    vec4 whole = step(cocs_around(at), vec4(same)), blurred = smoothstep(SHARP_PX, BLURRED_PX, abs(others));
    vec4 of_far = max(whole, covers * blurred * step(others, vec4(same)));
    vec4 of_near = whole * max(covers, step(others, vec4(ray.start)));
    vec4 soft = mix(of_near, of_far, notEqual(words & FAR_BIT, uvec4(0u)));
    return mix(whole, soft, smoothstep(MAGNIFIED, MAGNIFIED_FULL, magnified));
}

#ifdef LISTS
// True for those of the four surrounding pixels that show something nearer than a surface at the coc `met`.
bvec4 show_nearer(Ray ray, vec2 at, float met) { return lessThan(cocs_around(at), vec4(met - same_px(ray, met))); }

// True if only lists tell the shares that a surface at the coc `met` covers of the four surrounding pixels.
bool is_told_by_lists(Ray ray, vec2 at, float met) {
    return any(equal(words_around(at), uvec4(LISTED_WORD))) || any(show_nearer(ray, at, met));
}

// A surface that a ray meets.
struct Met {
    vec2 at;         // where the ray crosses its depth
    float coc;
    bool is_listed;  // it was found in a list; else it is visible
};

// The range of the coc of fragments in a list that hide the highlight together with a surface: those of that surface, and
// all nearer ones if the list has what is visible.
vec2 hiding_range(Ray ray, Met met, List list) {
    if (list.has_front && !met.is_listed) return vec2(-1e30, ray.start);
    return met.coc + same_px(ray, met.coc) * vec2(-1.0, 1.0);
}

// Returns the shares of the four surrounding pixels that a surface covers; 0 without a search if `is_needed` is false.
// Lists tell it where they have what is visible, and where something nearer is: does the surface go on behind that?
vec4 covers_around(Ray ray, Met met, bool is_needed) {
    ivec2 first = ivec2(floor(met.at - 0.5)), last = textureSize(coc_tx, 0) - 1;
    vec4 seen = hits_around(ray, met.at, met.coc), nearer = vec4(show_nearer(ray, met.at, met.coc));
    vec4 uncovered = vec4(1.0);  // of each of the four pixels
    int pixel = 0;  // in the order of textureGather
    uint passed = 0u;  // fragments of this pixel already looked at; one flat loop goes over all pixels and fragments
    while (is_needed && pixel < 4) {
        List list = list_at(clamp(first + ivec2(pixel == 1 || pixel == 2, pixel < 2), ivec2(0), last));
        uint i = list.first + passed++;
        Fragment fragment = fragment_of(min(i, max(list.end, 1u) - 1u));
        vec4 is_pixel = vec4(equal(ivec4(0, 1, 2, 3), ivec4(pixel)));
        bool is_told = list.has_front || (dot(nearer, is_pixel) > 0.0 && list.first < list.end);
        vec2 range = hiding_range(ray, met, list);
        bool is_reached = is_told && i < list.end && fragment.coc <= range.y;
        float covered = is_reached && fragment.coc >= range.x ? fragment.cover : is_told ? 0.0 : 1.0;
        float share = is_told && (met.is_listed || !list.has_front) ? 1.0 : dot(seen, is_pixel);
        uncovered *= 1.0 - covered * share * is_pixel;
        if (!is_reached || i + 1u == list.end) {
            ++pixel;
            passed = 0u;
        }
    }
    return 1.0 - uncovered;
}

// Share of the highlight that is hidden by visible surfaces (`hidden`), at the steps `listed_steps` (bits) by listed
// surfaces, which may be behind a nearer visible one, or at the steps `mixed_steps` by pixels that show several surfaces
// or one of which is nearer than what the ray meets.
// What is wholly hidden already needs no search, which is the largest part of a ray's time.
float hidden_by_lists(Ray ray, uint listed_steps, uint mixed_steps, float hidden) {
    uint passed = 0u;  // fragments of this step already looked at; one flat loop goes over all steps and fragments
    while ((listed_steps | mixed_steps) != 0u && hidden < 1.0) {
        bool is_listed = listed_steps != 0u;  // the listed steps are examined first, then the mixed ones
        float level = level_at(ray, lowest_bit(is_listed ? listed_steps : mixed_steps));
        List list = list_at(inside(crossing(ray, level)));
        uint i = list.first + passed++;
        float coc = fragment_of(min(i, max(list.end, 1u) - 1u)).coc;
        bool is_reached = is_listed && i < list.end && coc < ray.start && coc <= level + ray.step_px;
        bool is_needed = is_listed ? is_reached && coc >= level - ray.step_px : mixed_steps != 0u;
        float crossed = is_listed ? coc : coc_around(crossing(ray, level), level);
        Met met = Met(crossing(ray, crossed), crossed, is_listed);
        vec4 covers = covers_around(ray, met, is_needed);
        if (is_needed) hidden = max(hidden, dot(covers, weights_around(met.at)));
        if (!is_reached || i + 1u == list.end) {
            if (is_listed) listed_steps &= listed_steps - 1u;
            else mixed_steps &= mixed_steps - 1u;
            passed = 0u;
        }
    }
    return hidden;
}
#endif

// Share of the highlight that is hidden by visible surfaces at the steps `visible_steps` (bits), where the ray crosses
// their depths. With LISTS, steps of which only lists tell enough are added to `mixed_steps` instead.
float hidden_by_visible(Ray ray, uint visible_steps, inout uint mixed_steps) {
    float hidden = 0.0;
    do {
        float level = level_at(ray, lowest_bit(visible_steps)), met = coc_around(crossing(ray, level), level);
        vec2 crossed = crossing(ray, met);
        float hit = dot(hits_around(ray, crossed, met), weights_around(crossed));
        uint step_bit = visible_steps & (~visible_steps + 1u);  // the lowest bit; 0 in the one round without any
        bool is_met = step_bit != 0u && met < ray.start && abs(met - level) <= ray.step_px;
#ifdef LISTS
        if (is_met && is_told_by_lists(ray, crossed, met)) {
            mixed_steps |= step_bit;
            hit = 0.0;
        }
#endif
        if (is_met) hidden = max(hidden, hit);
        visible_steps ^= step_bit;
    } while (visible_steps != 0u && hidden < 1.0);
    return hidden;
}

// Share of the highlight hidden from the point of the lens that the pixel `at` stands for, 0..1: smooth across an
// occluder's edge. The highlight is at `center` and has this coc; `may_meet_px` is the least coc of all that rays to it
// may meet. Steps that meet a surface are collected as bits and examined in a second loop, because a software rasterizer
// runs the whole body of a loop as soon as one of its invocations needs part of it.
float hidden_share(vec2 at, vec2 center, float coc, float may_meet_px) {
    float start = coc - margin_of(coc);
    vec2 per_px = (at - center) / coc;
    int steps = clamp(int(ceil(length(per_px) * (start - nearest_px) / STEP_PX)), 1, STEPS);
    Ray ray = Ray(center, per_px, coc, start, (start - nearest_px) / float(steps));
    // Bit k is set if step k may meet a visible surface or listed ones, or meets pixels of which only lists tell enough.
    uint visible_steps = 0u, listed_steps = 0u, mixed_steps = 0u;
    bool is_inside = ray.step_px > 0.0;
    int k = 0;
    do {
        float level = level_at(ray, k);
        vec2 crossed = crossing(ray, level);
        is_inside = is_inside && !is_outside(crossed) && level + ray.step_px >= may_meet_px;
        vec2 range = texelFetch(ranges_tx, inside(crossed - 0.5), 0).rg;
        bool may_meet = range.r < min(start, level + ray.step_px) && range.g >= level - ray.step_px;
        if (is_inside && may_meet) visible_steps |= 1u << k;
#ifdef LISTS
        float first = texelFetch(kind_tx, inside(crossed), 0).b;
        if (is_inside && first < min(start, level + ray.step_px)) listed_steps |= 1u << k;
#endif
    } while (is_inside && ++k < steps);
    float hidden = hidden_by_visible(ray, visible_steps, mixed_steps);
#ifdef LISTS
    hidden = hidden_by_lists(ray, listed_steps, mixed_steps, hidden);
#endif
    return hidden;
}

// Share of the opening at a point of the lens, in diameters of the opening from its middle; soft at the rim.
float opening_at(vec2 point, float coc, vec2 center) {
    float px = sign(coc) * OPENING_PX;
    return most_of(aperture_coverage(px * point, 0.5 * px, RIM_PX, center));
}

// The mean of hidden_share over all points of the lens from which light of the highlight reaches the pixel `at`: it fills
// a square of half the side `ramp`. Seen from points far apart, what is much nearer than the highlight moves by several
// pixels: a single ray would meet a gap or miss it. The number of rays is no whole one, and they move apart as the second
// one begins to count: during a focus pull nothing jumps.
float mean_hidden_share(vec2 at, vec2 center, float coc, float ramp, float may_meet_px) {
    vec2 reach = aperture_reach(0.5 * coc, 0.0) / abs(coc), spread = vec2(ramp / abs(coc));
    vec2 middle = clamp((at - center) / coc, -reach, reach);
    vec2 low = clamp(middle - spread, -reach, reach), high = clamp(middle + spread, -reach, reach);
    float moved_px = max(high.x - low.x, high.y - low.y) * abs(may_meet_px);  // of the nearest surface
    float most = min(RAYS_OF_POINT + RAYS_A_PX * abs(coc), RAYS_MOST);
    float rays = clamp(moved_px * moved_px / (PX_A_RAY * PX_A_RAY), 1.0, most), apart = min(rays - 1.0, 1.0);
    vec2 offset = center.x * SPREAD_X + center.y * SPREAD_Y;
    float hidden = 0.0, sum = 0.0;
    int ray = 0;
    do {
        vec2 point = mix(middle, mix(low, high, fract(offset + float(ray) * SPREAD_RAYS)), apart);
        float share = min(rays - float(ray), 1.0) * max(opening_at(point, coc, center), LEAST_SHARE);
        hidden += share * hidden_share(at, at - point * coc, coc, may_meet_px);
        sum += share;
    } while (float(++ray) < rays);
    return hidden / sum;
}

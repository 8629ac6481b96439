// Builds the fragment lists of a smaller picture from those of the whole one: each pixel merges the lists of the pixels
// in its footprint, which is the area of the whole picture that it covers, and averages their coverage. Fragments at
// nearly the same distance become one, as a group. If too many groups are left, the range is cut into even steps of
// dioptres, because blur is linear in dioptres.
//
// The visible surfaces are included if their coverage is known (is_measured, or a list that begins with the visible
// surface). If not, the smaller picture shows them by color and depth like a picture without lists, and its lists hold
// only what is behind them, taken from pixels that show no farther surface.
//
// Built twice: with COUNT, the pass writes the length of each list; without, after peel_starts.comp.glsl, the lists.
//
// Words: open, the share of a pixel that the fragments so far leave uncovered; seen, what is visible through it; behind
// or hidden, what nearer fragments of the same pixel cover; front, the visible surface of a pixel.
//
// Inputs
//   color_tx, depth_tx   rgba premultiplied, and r meters, of the whole picture
//   lib/fragment_list.lib.glsl   its lists; a fragment_line of (0, 1) makes the coc of a fragment its dioptres
//   proxy_start_buf      without COUNT: the starts of the new lists
// In and out
//   depth_img            r meters of the smaller picture; without COUNT, where the list begins with the visible
//                        surface, those of its first fragment are written
// Output with COUNT
//   proxy_start_buf      twice the length of each list, plus 1 if it begins with the visible surface
// Output without COUNT
//   proxy_fragment_buf   the fragments, packed as in fragment_buf

#include "lib/footprint.lib.glsl"  // Footprint, footprint_of, share_in
#include "lib/fragment_list.lib.glsl"  // List, list_at, fragment_of, Fragment, WORDS, fragment_words

layout(local_size_x = PIXEL_GROUP, local_size_y = PIXEL_GROUP) in;

uniform sampler2D color_tx;
uniform sampler2D depth_tx;
uniform ivec2 size;         // size of the smaller picture
layout(r32f) uniform image2D depth_img;
uniform bool is_measured;   // the lists hold the coverage of all visible surfaces

#ifdef COUNT
layout(std430) writeonly buffer proxy_start_block { uint proxy_start_buf[]; };
#else
layout(std430) readonly buffer proxy_start_block { uint proxy_start_buf[]; };
layout(std430) writeonly buffer proxy_fragment_block { uint proxy_fragment_buf[]; };
#endif

#define SAME_GROUP 1.03    // relative distance within which surfaces become one fragment
#define GROUPS_MOST 8      // largest number of groups before the range is cut into even steps
#define LEAST_COVER 1e-4   // less coverage than this counts as none
#define WHOLE_COVER 0.9995  // coverage from which a group covers the pixel in full
#define SIDE_MOST 5        // pixels read along a side of a footprint; larger footprints are sampled evenly

ivec2 whole_size;      // size of the whole picture
Footprint footprint;
bool includes_fronts;  // the list includes the visible surfaces, not just those behind
ivec2 stride;          // step from one pixel read to the next
float sampled_share;    // share of the footprint that was sampled
float farthest_front;  // dioptres just beyond what the smaller pixel shows; farther fronts do not count
float farthest_group;  // dioptres: far and near end of a list that would be too long and is cut into even steps;
float nearest_group;   // both are equal if it needs no cuts

struct Group {
    vec4 seen;    // rgb and dioptres, times visible share of the pixel
    float cover;  // visible share
    vec4 behind;  // the same for the share hidden by nearer fragments of the same pixels
    float behind_cover;
};

// Adds a fragment to a group if its dioptres are above `low` and at most `high`. `open` is the open share of its pixel:
// in front of the fragment before the call, behind it after.
void add(inout Group group, Fragment fragment, float pixel_share, inout float open, float low, float high) {
    if (!includes_fronts && fragment.coc > farthest_front) return;  // the same surface as the visible one
    if (fragment.coc > low && fragment.coc <= high) {
        float seen = pixel_share * open * fragment.cover, hidden = pixel_share * (1.0 - open) * fragment.cover;
        group.seen += seen * vec4(fragment.color, fragment.coc);
        group.cover += seen;
        group.behind += hidden * vec4(fragment.color, fragment.coc);
        group.behind_cover += hidden;
    }
    open *= 1.0 - fragment.cover;
}

// The visible surface of a pixel whose list does not begin with it, as a fragment.
Fragment front_of(ivec2 pixel) {
    vec4 x = texelFetch(color_tx, pixel, 0);
    float cover = clamp(x.a, 0.0, 1.0);
    if (cover >= WHOLE_COVER) cover = 1.0;
    return Fragment(x.rgb / max(cover, LEAST_COVER), cover, 1.0 / texelFetch(depth_tx, pixel, 0).r);
}

// True if a pixel of the footprint contributes to the list.
bool is_counted(ivec2 pixel, List list) {
    if (includes_fronts) return true;
    return list.end > list.first && 1.0 / texelFetch(depth_tx, pixel, 0).r >= farthest_front;
}

// The group of all fragments in the footprint from `high` dioptres down to, but excluding, `low`.
Group group_within(float low, float high) {
    Group group = Group(vec4(0.0), 0.0, vec4(0.0), 0.0);
    for (int y = footprint.first.y; y <= footprint.last.y; y += stride.y)
        for (int x = footprint.first.x; x <= footprint.last.x; x += stride.x) {
            ivec2 pixel = ivec2(x, y);
            List list = list_at(pixel);
            if (!is_counted(pixel, list)) continue;
            float pixel_share = share_in(footprint, pixel) / sampled_share, open = 1.0;
            if (includes_fronts && !list.has_front) add(group, front_of(pixel), pixel_share, open, low, high);
            for (uint i = list.first; i < list.end; ++i) add(group, fragment_of(i), pixel_share, open, low, high);
        }
    return group;
}

// Dioptres of the nearest fragment at or beyond `high`; -1 for none.
float nearest_from(float high) {
    float nearest = -1.0;
    for (int y = footprint.first.y; y <= footprint.last.y; y += stride.y)
        for (int x = footprint.first.x; x <= footprint.last.x; x += stride.x) {
            ivec2 pixel = ivec2(x, y);
            List list = list_at(pixel);
            if (!is_counted(pixel, list)) continue;
            Fragment front = front_of(pixel);
            bool is_front = includes_fronts && !list.has_front && front.cover > LEAST_COVER;
            if (is_front && front.coc <= high) nearest = max(nearest, front.coc);
            for (uint i = list.first; i < list.end; ++i) {
                float dioptres = fragment_of(i).coc;
                if (dioptres <= high) nearest = max(nearest, dioptres);
            }
        }
    return nearest;
}

// The far end, in dioptres, of the group whose nearest fragment is at `nearest`. It is below 0 if the group takes all
// that is left, to infinity.
float end_of_group(float nearest) {
    if (nearest <= 0.0) return -0.5;
    if (farthest_group == nearest_group) return nearest / SAME_GROUP;
    float cut = (nearest_group - farthest_group) / float(GROUPS_MOST);
    float number = min(floor((nearest_group - nearest) / cut), float(GROUPS_MOST - 1));
    return number == float(GROUPS_MOST - 1) ? -0.5 : min(nearest_group - (number + 1.0) * cut, nearest);
}

// Sets the variables above for a pixel of the smaller picture.
void begin(ivec2 at) {
    whole_size = textureSize(color_tx, 0);
    footprint = footprint_of(at, size, whole_size);
    stride = (footprint.last - footprint.first + SIDE_MOST) / SIDE_MOST;
    includes_fronts = is_measured;
    nearest_group = farthest_group = sampled_share = 0.0;
    for (int y = footprint.first.y; y <= footprint.last.y; y += stride.y)
        for (int x = footprint.first.x; x <= footprint.last.x; x += stride.x)
            includes_fronts = includes_fronts || list_at(ivec2(x, y)).has_front;
    farthest_front = 1.0 / (imageLoad(depth_img, at).r * SAME_GROUP);
    for (int y = footprint.first.y; y <= footprint.last.y; y += stride.y)
        for (int x = footprint.first.x; x <= footprint.last.x; x += stride.x) {
            ivec2 pixel = ivec2(x, y);
            if (is_counted(pixel, list_at(pixel))) sampled_share += share_in(footprint, pixel);
        }
}

// Counts the groups from `first` dioptres on. If there are too many, sets the range that is cut evenly.
void limit_groups(float first) {
    float high = first, least = -1.0, most = -1.0;
    int count = 0;
    for (; count < 4 * GROUPS_MOST; ++count) {
        float nearest = nearest_from(high);
        if (nearest < 0.0) break;
        if (count == 0) most = nearest;
        least = nearest;
        high = end_of_group(nearest);
    }
    if (count <= GROUPS_MOST) return;
    nearest_group = most;
    farthest_group = least;
}

#ifndef COUNT
void write_fragment(uint number, vec3 color, float cover, float dioptres) {
    uvec3 words = fragment_words(color, cover, dioptres);
    for (uint i = 0u; i < WORDS; ++i) proxy_fragment_buf[WORDS * number + i] = words[i];
}
#endif

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(at, size))) return;
    begin(at);
    uint index = uint(at.y * size.x + at.x), count = 0u;
    // high: dioptres at which the next group begins. Skips the surface that a picture without lists shows, unless the
    // list includes it. open: share of the smaller pixel that the groups so far leave uncovered.
    float high = includes_fronts ? 1e30 : farthest_front, open = 1.0;
    bool has_front = false, is_first = includes_fronts;
    limit_groups(high);
#ifndef COUNT
    uint start = proxy_start_buf[index] >> 1, list_capacity = (proxy_start_buf[index + 1u] >> 1) - start;
    if (list_capacity == 0u) return;
#endif
    for (int k = 0; k < 2 * GROUPS_MOST; ++k) {
        float nearest = nearest_from(high);
        if (nearest < 0.0) break;
        float low = end_of_group(nearest);
        Group group = group_within(low, high);
        high = low;
        bool is_visible = group.cover > LEAST_COVER;
        float cover = is_visible ? min(group.cover / max(open, LEAST_COVER), 1.0) : group.behind_cover;
        if (cover >= WHOLE_COVER) cover = 1.0;
        // Hidden surfaces must not fill the rest of the pixel, which belongs to visible ones.
        if (cover <= LEAST_COVER || !is_visible && open > 0.0) continue;
        if (is_visible) open = max(open - group.cover, 0.0);
        if (open < LEAST_COVER) open = 0.0;
        bool is_shown = is_first && cover == 1.0;  // the picture itself shows it
        has_front = has_front || is_first && !is_shown;
#ifndef COUNT
        vec4 mean = is_visible ? group.seen / group.cover : group.behind / group.behind_cover;
        if (!is_shown && count < list_capacity) write_fragment(start + count, mean.rgb, cover, mean.a);
        if (is_first && !is_shown) imageStore(depth_img, at, vec4(1.0 / mean.a));
#endif
        is_first = false;
        if (!is_shown) ++count;
    }
#ifdef COUNT
    proxy_start_buf[index] = 2u * count + (has_front ? 1u : 0u);
#endif
}

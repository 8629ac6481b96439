// Measures the brightness ratio between the visible part of a surface and its listed part just behind a
// silhouette. Renderers may light hidden surfaces differently, and a clean plate may lack a shadow:
// without this correction the silhouette would show as a step through the blur.
//
// Part of hidden_cost.comp.glsl.

uniform sampler2D state_tx;
uniform sampler2D listed_tx;
layout(rgba32f) uniform writeonly image2D out_match_img;

#define MATCH_TAPS 8            // pixels from the end on: enough that texture does not decide
#define SAME_DIAMETER_PX 0.5    // the diameter of one surface may change by this much,
#define SAME_DIAMETER_PART 0.1  // as a share of the diameter
#define LEAST_LIGHT 0.01        // darker pixels are not compared
#define INDEPENDENT 4.0         // largest number of independent pixels: neighbours are alike
#define SURE_VARIANCE 0.03      // standard deviation of the logarithm: stronger texture weakens the match
#define ALIKE_LOG 0.7           // a factor of two or more may mean another surface,
#define UNLIKE_LOG 1.2          // logarithm from which they always are

struct Stretch {
    vec4 sum;          // rgb times coverage, coverage
    float variance;    // variance of the mean of its logarithms of luminance
};

// Statistics of a stretch of one surface, at most `taps` pixels long.
Stretch stretch_of(ivec2 from, ivec2 onward, bool hidden, float diameter, int taps) {
    vec4 sum = vec4(0.0);
    float count = 0.0, logs = 0.0, squares = 0.0;
    float most = max(SAME_DIAMETER_PX, SAME_DIAMETER_PART * diameter);
    int tap = 0;
    do {
        ivec2 p = from + tap * onward;
        if (p != clamp(p, ivec2(0), layer_size - 1)) break;
        if (abs(texelFetch(state_tx, p, 0).r - diameter) > most) break;
        vec4 layer = texelFetch(layer_tx, p, 0);
        if (hidden) layer.a = marked_cover(layer.a);
        sum += (hidden ? texelFetch(listed_tx, p, 0).r : 1.0) * layer;
        float light = log(mean_of(layer.rgb) / max(layer.a, 1e-3) + LEAST_LIGHT);
        count += 1.0;
        logs += light;
        squares += light * light;
    } while (++tap < min(taps, MATCH_TAPS));
    float spread = squares / max(count, 1.0) - logs * logs / max(count * count, 1.0);
    return Stretch(sum, max(spread, 0.0) / min(max(count - 1.0, 1.0), INDEPENDENT));
}

// Adds the measurement at one end along direction `k`, so many steps ahead, or back if less than 0; the
// hidden pixel stands among `hidden_px` in a row.
void add_match(inout vec4 sum, ivec2 at, int k, int ahead, int hidden_px) {
    int steps = abs(ahead);
    ivec2 onward = sign(ahead) * DIRECTION[k], end = at + steps * onward;
    float diameter = texelFetch(state_tx, end, 0).r;
    Stretch one = stretch_of(end, onward, false, diameter, seen_in_row(k, end, ahead > 0, layer_size));
    Stretch other = stretch_of(end - onward, -onward, true, diameter, hidden_px);
    if (min(one.sum.a, other.sum.a) < 0.5) return;
    vec4 seen = one.sum, listed = other.sum;
    vec3 ratio = log((seen.rgb / seen.a + LEAST_LIGHT) / (listed.rgb / listed.a + LEAST_LIGHT));
    // Uncertain measurements count less, and their hue even less.
    float sure = SURE_VARIANCE / (SURE_VARIANCE + one.variance + other.variance), grey = mean_of(ratio);
    ratio = sure * (vec3(grey) + sure * (ratio - grey));
    float likeness = 1.0 - smoothstep(ALIKE_LOG, UNLIKE_LOG, max(abs(ratio.r), max(abs(ratio.g), abs(ratio.b))));
    float length_px = float(steps) * length(vec2(onward));
    sum += likeness / (length_px * length_px) * vec4(ratio, 1.0);
}

vec4 match_of(ivec2 at, ivec2 ends[HIDDEN_DIRECTIONS], bool is_asked) {
    vec4 sum = vec4(0.0);
    int i = 0;
    do {
        int k = i >> 1, ahead = (i & 1) == 0 ? ends[k].x : -ends[k].y;
        bool has_both = min(ends[k].x, ends[k].y) > 0;  // otherwise they go on to the picture's edge
        if (is_asked && ahead != 0) add_match(sum, at, k, ahead, has_both ? ends[k].x + ends[k].y - 1 : MATCH_TAPS);
    } while (is_asked && ++i < 2 * HIDDEN_DIRECTIONS);
    return vec4(sum.rgb / max(sum.a, 1e-9), sum.a);
}

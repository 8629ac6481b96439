// Measures the brightness ratio between the visible part of a surface and its hidden part just behind a silhouette,
// which is known from fragment lists (listed). Renderers may light hidden surfaces differently, and a clean plate may
// lack a shadow: without this correction the silhouette would show as a step through the blur.
//
// Part of hidden_cost.comp.glsl. A hidden pixel has up to two ends along each direction of lib/hidden.lib.glsl: the
// nearest visible pixels ahead and back. At each end a stretch of visible pixels, from the end on away from the hidden
// pixel, is compared with a stretch of listed pixels, from the end back towards the hidden pixel.
//
// Inputs
//   state_tx       r diameter |coc|, pixels
//   listed_tx      r share known from the list
//   layer_tx       rgb times coverage, a coverage; below 0 in a hidden pixel, where marked_cover of lib/hidden.lib.glsl
//                  takes the coverage out of it
// Output
//   out_match_img  rgb logarithm of visible / listed brightness, a confidence

uniform sampler2D state_tx;
uniform sampler2D listed_tx;
layout(rgba32f) uniform writeonly image2D out_match_img;

#define MATCH_PX 8               // pixels to compare on each side of an end; fewer would measure texture
#define MATCH_STEP_PX 2          // from one of those that are read to the next: neighbors are alike
#define SAME_DIAMETER_PX 0.5     // change of the diameter up to which pixels are of one surface
#define SAME_DIAMETER_SHARE 0.1  // the same as a share of the diameter; the larger limit counts
#define LEAST_LIGHT 0.01         // added to the light, because dark pixels are not compared
#define INDEPENDENT 4.0          // largest number of pixels that count as independent, because neighbors are alike
#define SURE_VARIANCE 0.03       // variance of the logarithm at which the match has half its weight
#define ALIKE_LOG 0.7            // logarithm of the ratio up to which surfaces are the same
#define UNLIKE_LOG 1.2           // logarithm from which they are different
#define LEAST_PIXELS 0.5         // least sum of coverage on either side of an end for a measurement

// Pixels in a row that belong to one surface.
struct Stretch {
    vec4 sum;          // rgb times coverage, coverage
    float variance;    // variance of the mean of the logarithms of the light
};

// Statistics of the stretch that starts at `from` and has this diameter, at most `length_px` long. The loop is a
// `do ... while`, see shaders/README.md.
Stretch stretch_of(ivec2 from, ivec2 away_direction, bool hidden, float diameter, int length_px) {
    vec4 sum = vec4(0.0);
    float count = 0.0, logs = 0.0, squares = 0.0;
    float most = max(SAME_DIAMETER_PX, SAME_DIAMETER_SHARE * diameter);
    int px = 0;
    do {
        ivec2 p = from + px * away_direction;
        if (p != clamp(p, ivec2(0), layer_size - 1)) break;
        if (abs(texelFetch(state_tx, p, 0).r - diameter) > most) break;
        vec4 layer = texelFetch(layer_tx, p, 0);
        if (hidden) layer.a = marked_cover(layer.a);
        layer = without_weight(layer);
        sum += (hidden ? texelFetch(listed_tx, p, 0).r : 1.0) * layer;
        float light = log(mean_of(layer.rgb) / max(layer.a, 1e-3) + LEAST_LIGHT);
        count += 1.0;
        logs += light;
        squares += light * light;
    } while ((px += MATCH_STEP_PX) < min(length_px, MATCH_PX));
    float spread = squares / max(count, 1.0) - logs * logs / max(count * count, 1.0);
    return Stretch(sum, max(spread, 0.0) / min(max(count - 1.0, 1.0), INDEPENDENT));
}

// Adds the measurement at one end to a sum: rgb times weight, weight. The end is `ahead` steps away along direction
// `k`, negative for backwards; `hidden_px` is the number of hidden pixels in the row. Nearer ends have more weight.
void add_match(inout vec4 sum, ivec2 at, int k, int ahead, int hidden_px) {
    int steps = abs(ahead);
    ivec2 away_direction = sign(ahead) * DIRECTION[k], end = at + steps * away_direction;
    float diameter = texelFetch(state_tx, end, 0).r;
    Stretch front = stretch_of(end, away_direction, false, diameter, visible_in_row(k, end, ahead > 0, layer_size));
    Stretch back = stretch_of(end - away_direction, -away_direction, true, diameter, hidden_px);
    if (min(front.sum.a, back.sum.a) < LEAST_PIXELS) return;
    vec4 visible = front.sum, listed = back.sum;
    vec3 ratio = log((visible.rgb / visible.a + LEAST_LIGHT) / (listed.rgb / listed.a + LEAST_LIGHT));
    // Uncertain measurements count less, and their hue even less.
    float confidence = SURE_VARIANCE / (SURE_VARIANCE + front.variance + back.variance), grey = mean_of(ratio);
    ratio = confidence * (vec3(grey) + confidence * (ratio - grey));
    float similarity = 1.0 - smoothstep(ALIKE_LOG, UNLIKE_LOG, max(abs(ratio.r), max(abs(ratio.g), abs(ratio.b))));
    float length_px = float(steps) * length(vec2(away_direction));
    sum += similarity / (length_px * length_px) * vec4(ratio, 1.0);
}

// The mean of the measurements at all ends of a hidden pixel, if `is_needed`, and in a its confidence. `ends` has the
// steps ahead and back along each direction; 0 for no end.
vec4 match_of(ivec2 at, ivec2 ends[HIDDEN_DIRECTIONS], bool is_needed) {
    vec4 sum = vec4(0.0);
    int i = 0;
    do {
        int k = i >> 1, ahead = (i & 1) == 0 ? ends[k].x : -ends[k].y;
        bool has_both = min(ends[k].x, ends[k].y) > 0;  // otherwise the hidden pixels go on to the picture's edge
        if (is_needed && ahead != 0) add_match(sum, at, k, ahead, has_both ? ends[k].x + ends[k].y - 1 : MATCH_PX);
    } while (is_needed && ++i < 2 * HIDDEN_DIRECTIONS);
    return vec4(sum.rgb / max(sum.a, 1e-9), sum.a);
}

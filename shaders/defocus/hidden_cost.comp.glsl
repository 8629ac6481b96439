// Measures how much the two ends of each direction differ, for each block with hidden pixels: the cost of continuing
// the picture along that direction. A stripe that a wire interrupts has similar ends along the stripe.
// hidden_fill.comp.glsl gives such directions more weight.
//
// Words: a pixel of a layer is visible if nearer layers leave it open, and hidden if the layer must be guessed there
// (lib/hidden.lib.glsl). A block has 2 x 2 pixels. From a hidden pixel, each of four directions leads both ways to the
// next visible pixel, its two ends.
//
// Inputs
//   layer_tx       rgb times coverage, a coverage; below 0 in a hidden pixel (lib/hidden.lib.glsl)
//   bits_buf       a bit for each pixel, set if it is visible; each direction has a mask of its own
//   two lists      first: the first hidden pixel of each block (hidden_blocks.comp.glsl)
// Output (one texel a block; only blocks with hidden pixels are written)
//   out_cost_img   one channel a direction: mean squared difference of the ends in compressed color
//                  (lib/tone.lib.glsl), less if both ends are of one stripe; NO_COST if not both exist or are near
//                  enough. With LINES, behind wide things, rows and columns have the cost of a whole line, also
//                  with one end
// With MATCHED, for fragment lists whose hidden surfaces are lit differently from the visible ones, also
//   inputs   state_tx       r diameter |coc| in pixels of the layer, g share of content
//            listed_tx      r share of a pixel that only a list gives, g depth behind the silhouette, in pixels
//   output   out_match_img  rgb logarithm of the ratio of visible to listed brightness on the same surface, just
//                           beyond its end; a its confidence, -1 where it was not measured

#include "lib/hidden_block.lib.glsl"  // layer_size, PIXELS_PER_GROUP, FOR_EACH_IN_FIRST, pixel_of_word
#include "lib/visible_bits.lib.glsl"  // is_visible, is_beyond_reach, ends_of, DIRECTION
#include "lib/tone.lib.glsl"  // compress_light

layout(local_size_x = PIXELS_PER_GROUP) in;

uniform sampler2D layer_tx;
layout(rgba32f) uniform writeonly image2D out_cost_img;

#define TAPS 2            // pixels to compare on each side: the end and one pixel behind it
#define TAP_WEIGHT 0.5    // weight of the pixels behind the ends
#define BESIDE_PX 6       // distance at which the pixels beside an end are compared with it
#define STRIPE_GAIN 8.0   // how much more similar ends count for each unit of contrast beside them
#define ONE_END_COST 0.3  // cost of a direction with one end, where lines are followed too
#define STRIPE_COST 0.3   // cost from which two ends are too different for one stripe

// Returns whether a pixel is visible, and its compressed color times coverage, a coverage.
bool read_visible(ivec2 at, out vec4 toned_layer) {
    toned_layer = vec4(0.0);
    if (any(lessThan(at, ivec2(0))) || any(greaterThanEqual(at, layer_size))) return false;
    if (!is_visible(at, layer_size)) return false;
    vec4 layer = texelFetch(layer_tx, at, 0);
    toned_layer = vec4(compress_light(layer.rgb / max(layer.a, 1e-4)) * layer.a, layer.a);
    return true;
}

// Mean squared difference of the two ends along direction k, which lie `ends` steps ahead and back; -1 if nothing could
// be compared, as with 0 `taps`.
float difference(ivec2 at, int k, ivec2 ends, int taps) {
    float sum = 0.0, weights = 0.0;
    int tap = 0;
    do {
        vec4 a, b;
        bool are_visible = read_visible(at + (ends.x + tap) * DIRECTION[k], a);
        are_visible = read_visible(at - (ends.y + tap) * DIRECTION[k], b) && are_visible;
        if (!are_visible || tap >= taps) continue;
        float weight = tap == 0 ? 1.0 : TAP_WEIGHT;
        sum += weight * dot(a - b, a - b);
        weights += weight;
    } while (++tap < taps);
    return weights > 0.0 ? sum / weights : -1.0;
}

// Adds the contrast of an end, if `is_needed`: the squared differences from visible pixels beside it to x, those of the
// coverage alone to y, their number to z. `away` points away from the hidden pixel. Both of these pixels lie as far
// behind the end as beside it, because the silhouette of a round thing hides what is exactly beside it.
void add_contrast(inout vec3 sum, ivec2 end, ivec2 away, bool is_needed) {
    vec4 own, other;
    read_visible(end, own);
    ivec2 aside = ivec2(-away.y, away.x);
    int side = -1;
    do {
        if (!read_visible(end + BESIDE_PX * (away + side * aside), other)) continue;
        vec4 change = other - own;
        sum += vec3(dot(change, change), change.a * change.a, 1.0);
    } while (is_needed && (side += 2) < 2);
}

// The cost of direction k. Ends in a flat area are similar along every direction and tell nothing; similar ends that
// differ from what is beside them are those of a stripe, and count more. A bar of a window then goes on behind a leaf,
// although the ends across the bar, in the bright panes, are similar and nearer. The similarity is an exponential of the
// cost, so a factor for it is subtracted from the cost as a logarithm.
float cost_of(ivec2 at, int k, ivec2 ends, int taps) {
    float cost = difference(at, k, ends, taps);
    if (cost < 0.0) return NO_COST;
    vec3 contrast = vec3(0.0);
    add_contrast(contrast, at + ends.x * DIRECTION[k], DIRECTION[k], cost < STRIPE_COST);
    add_contrast(contrast, at - ends.y * DIRECTION[k], -DIRECTION[k], cost < STRIPE_COST);
    float excess = max(contrast.x / max(contrast.z, 1.0) - cost, 0.0);
    return cost - 2.0 * ALIKE_VARIANCE * log(1.0 + STRIPE_GAIN * excess);
}

#ifdef LINES
#define LINE_SAMPLES 12        // samples of a line behind each end
#define LINE_FADE 8.0          // distance in steps at which a sample has 1/e of the weight
#define STEADY_VARIANCE 0.003  // variance of a line up to which it is steady
#define STEADY_POWER 2.0       // the weight of a line falls with this power of its variance
#define BAR_GAIN 30.0          // how much more a line counts for each unit of contrast in coverage beside its ends
#define UNSTEADY 2.0           // contrast that each unit of variance cancels

// Adds samples of the line behind an end, which is `end_px` away: their weighted sum, and to squares.x the sum of their
// squares, to squares.y that of their weights.
void add_line(inout vec4 sum, inout vec2 squares, ivec2 at, int end_px, ivec2 away, int samples) {
    int i = 0;
    do {
        int distance_px = end_px + i * line_step_px;
        vec4 value;
        if (!read_visible(at + distance_px * away, value)) continue;
        float weight = exp(-float(distance_px) / (LINE_FADE * float(max(line_step_px, 1))));
        sum += weight * value;
        squares += weight * vec2(dot(value, value), 1.0);
    } while (++i < samples);
}

// The cost of a row or a column by the variance of all that is visible of it; NO_COST if nothing is. A bar is steady
// along itself, also where many things hide it. A line that crosses bars is not, although the two ends beside the
// hidden pixel may be similar. Where things in the way hide the other bars too, an edge of coverage beside the ends
// tells a bar.
float line_cost_of(ivec2 at, int k, ivec2 ends, int samples) {
    vec4 sum = vec4(0.0);
    vec2 squares = vec2(0.0);
    vec3 contrast = vec3(0.0);
    if (ends.x > 0) add_line(sum, squares, at, ends.x, DIRECTION[k], samples);
    if (ends.y > 0) add_line(sum, squares, at, ends.y, -DIRECTION[k], samples);
    if (squares.y == 0.0) return NO_COST;
    if (ends.x > 0) add_contrast(contrast, at + ends.x * DIRECTION[k], DIRECTION[k], samples > 0);
    if (ends.y > 0) add_contrast(contrast, at - ends.y * DIRECTION[k], -DIRECTION[k], samples > 0);
    float variance = max(squares.x - dot(sum, sum) / squares.y, 0.0) / squares.y;
    float excess = max(contrast.y / max(contrast.z, 1.0) - UNSTEADY * variance, 0.0);
    float unsteadiness = STEADY_POWER * log(1.0 + variance / STEADY_VARIANCE);
    return 2.0 * ALIKE_VARIANCE * (unsteadiness - log(1.0 + BAR_GAIN * excess));
}

// Mixes the costs of row and column as whole lines into the costs of the directions.
vec4 with_lines(vec4 cost, ivec2 at, ivec2 across, ivec2 down, float share) {
    int samples = share > 0.0 ? LINE_SAMPLES : 0;
    vec2 lines = vec2(line_cost_of(at, 0, across, samples), line_cost_of(at, 1, down, samples));
    vec2 ends = mix(vec2(ONE_END_COST), cost.xy, step(0.5 * NO_COST, cost.xy));
    vec2 mixed = mix(NO_COST + vec2(0.0), mix(ends, lines, share), step(0.5 * NO_COST, lines));
    return share > 0.0 ? vec4(mixed, cost.zw) : cost;
}
#endif

#ifdef MATCHED
#include "lib/match.lib.glsl"  // match_of, out_match_img
#endif

// Measures the block of a listed pixel, from that pixel.
void compare_ends(uint listed) {
    ivec2 at = pixel_of_word(listed);
    vec4 cost = vec4(NO_COST);
    ivec2 ends[HIDDEN_DIRECTIONS];
    for (int k = 0; k < HIDDEN_DIRECTIONS; ++k) ends[k] = ends_of(k, at, layer_size);
    bool is_in_reach = !is_beyond_reach(ends);  // the lens never sees a pixel beyond reach
    float line_share = is_in_reach ? line_share_of(ends[0], ends[1]) : 0.0;
    int taps = is_in_reach && line_share < 1.0 ? TAPS : 0;  // where lines alone decide, ends are not compared
    for (int k = 0; k < HIDDEN_DIRECTIONS; ++k)
        if (all(greaterThan(ends[k], ivec2(0)))) cost[k] = cost_of(at, k, ends[k], taps);
#ifdef LINES
    cost = with_lines(cost, at, ends[0], ends[1], line_share);
#endif
    imageStore(out_cost_img, at >> 1, cost);
#ifdef MATCHED
    imageStore(out_match_img, at >> 1, match_of(at, ends, is_in_reach));
#endif
}

void main() { FOR_EACH_IN_FIRST(compare_ends) }

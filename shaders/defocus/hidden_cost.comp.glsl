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
//   bits_buf, words_buf   visible pixels (lib/visible_ends.lib.glsl)
//   two lists      first: the first hidden pixel of each block (hidden_blocks.comp.glsl)
//   coc_tx         r signed coc of the picture, read where a surface passes into the layer (lib/entering.lib.glsl)
// Output (one texel a block; only blocks with hidden pixels are written)
//   cost_img       one channel a direction: mean squared difference of the ends in compressed color
//                  (lib/tone.lib.glsl), less if both ends are of one stripe; NO_COST if not both exist or are near enough;
//                  in the second round it has those of the first before
// With MATCHED, for fragment lists whose hidden surfaces are lit differently from the visible ones, also
//   inputs   state_tx       r diameter |coc| in pixels of the layer, g share of content
//            listed_tx      r share of a pixel that only a list gives, g depth behind the silhouette, in pixels
//   output   out_match_img  rgb logarithm of the ratio of visible to listed brightness on the same surface, just
//                           beyond its end; a its confidence, -1 where it was not measured

#include "lib/hidden_block.lib.glsl"  // layer_size, PIXELS_PER_GROUP, FOR_EACH_IN_FIRST, pixel_of_word
#include "lib/entering.lib.glsl"  // is_second_round, has_entering, entering_of
#include "lib/visible_ends.lib.glsl"  // is_visible, is_beyond_reach, all_ends_of, DIRECTION
#include "lib/tone.lib.glsl"  // compress_light

layout(local_size_x = PIXELS_PER_GROUP) in;

uniform sampler2D layer_tx;
layout(rgba32f) uniform image2D cost_img;

#define TAPS 2            // pixels to compare on each side: the end and one pixel behind it
#define TAP_WEIGHT 0.5    // weight of the pixels behind the ends
#define BESIDE_PX 6       // distance at which the pixels beside an end are compared with it
#define STRIPE_GAIN 8.0   // how much more similar ends count for each unit of contrast beside them
#define STRIPE_COST 0.3   // cost from which two ends are too different for one stripe

// Returns whether a pixel is visible, and its compressed color times coverage, a coverage.
bool read_visible(ivec2 at, out vec4 toned_layer) {
    toned_layer = vec4(0.0);
    if (any(lessThan(at, ivec2(0))) || any(greaterThanEqual(at, layer_size))) return false;
    if (!is_visible(at, layer_size)) return false;
    vec4 layer = without_weight(texelFetch(layer_tx, at, 0));
    toned_layer = vec4(compress_light(layer.rgb / max(layer.a, 1e-4)) * layer.a, layer.a);
    return true;
}

// Mean squared difference of the two ends along direction k, which lie `ends` steps ahead and back; -1 if nothing could
// be compared.
float difference(ivec2 at, int k, ivec2 ends) {
    float sum = 0.0, weights = 0.0;
    int tap = 0;
    do {
        vec4 a, b;
        bool are_visible = read_visible(at + (ends.x + tap) * DIRECTION[k], a);
        are_visible = read_visible(at - (ends.y + tap) * DIRECTION[k], b) && are_visible;
        if (!are_visible) continue;
        float weight = tap == 0 ? 1.0 : TAP_WEIGHT;
        sum += weight * dot(a - b, a - b);
        weights += weight;
    } while (++tap < TAPS);
    return weights > 0.0 ? sum / weights : -1.0;
}

// Adds the contrast of an end, if `is_needed`: the squared differences from visible pixels beside it to x, their number
// to y. `away` points away from the hidden pixel. Both of these pixels lie as far behind the end as beside it, because
// the silhouette of a round thing hides what is exactly beside it.
void add_contrast(inout vec2 sum, ivec2 end, ivec2 away, bool is_needed) {
    vec4 own, other;
    read_visible(end, own);
    ivec2 aside = ivec2(-away.y, away.x);
    int side = -1;
    do {
        if (!read_visible(end + BESIDE_PX * (away + side * aside), other)) continue;
        sum += vec2(dot(other - own, other - own), 1.0);
    } while (is_needed && (side += 2) < 2);
}

// The cost of direction k. Ends in a flat area are similar along every direction and tell nothing; similar ends that
// differ from what is beside them are those of a stripe, and count more. A bar of a window then goes on behind a leaf,
// although the ends across the bar, in the bright panes, are similar and nearer. The similarity is an exponential of the
// cost, so a factor for it is subtracted from the cost as a logarithm.
float cost_of(ivec2 at, int k, ivec2 ends) {
    float cost = difference(at, k, ends);
    if (cost < 0.0) return NO_COST;
    vec2 contrast = vec2(0.0);
    add_contrast(contrast, at + ends.x * DIRECTION[k], DIRECTION[k], cost < STRIPE_COST);
    add_contrast(contrast, at - ends.y * DIRECTION[k], -DIRECTION[k], cost < STRIPE_COST);
    float excess = max(contrast.x / max(contrast.y, 1.0) - cost, 0.0);
    return cost - 2.0 * ALIKE_VARIANCE * log(1.0 + STRIPE_GAIN * excess);
}

#ifdef MATCHED
#include "lib/match.lib.glsl"  // match_of, out_match_img
#endif

// The costs of the second round, mixed with those of the first as far as the ends of the second are partly known.
vec4 mixed_with_first(vec4 first, vec4 second, ivec2 at, ivec2 ends[HIDDEN_DIRECTIONS]) {
    vec2 entering = vec2(0.0);
    for (int k = 0; k < HIDDEN_DIRECTIONS; ++k) entering += entering_of(at, k, ends[k], vec2(1.0));
    vec4 mixed = mix(first, second, entering.y > 0.0 ? entering.x / entering.y : 0.0);
    return mix(mixed, second, lessThan(first, vec4(0.5 * NO_COST)));
}

// Measures the block of a listed pixel, from that pixel.
void compare_ends(uint listed) {
    ivec2 at = pixel_of_word(listed);
    vec4 cost = vec4(NO_COST);
    ivec2 ends[HIDDEN_DIRECTIONS] = all_ends_of(at, layer_size);
    bool needs_ends = line_share_of(ends[0], ends[1], reach_px) < 1.0;  // lines alone need no ends
    bool is_in_reach = !is_beyond_reach(ends) && (!is_second_round || has_entering(at, ends));
    bool is_needed = needs_ends && is_in_reach;  // a lens sees nothing beyond reach
    for (int k = 0; is_needed && k < HIDDEN_DIRECTIONS; ++k)
        if (all(greaterThan(ends[k], ivec2(0)))) cost[k] = cost_of(at, k, ends[k]);
    if (is_second_round) cost = mixed_with_first(imageLoad(cost_img, at >> 1), cost, at, ends);
    imageStore(cost_img, at >> 1, cost);
#ifdef MATCHED
    imageStore(out_match_img, at >> 1, match_of(at, ends, is_in_reach));
#endif
}

void main() { FOR_EACH_IN_FIRST(compare_ends) }

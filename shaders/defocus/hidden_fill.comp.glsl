// Guesses hidden pixels by interpolation between the two ends of each direction.
//
// A direction has more weight the more similar its ends are and the nearer they are. Similarity is taken over a small
// neighborhood, because one pixel must not decide. An end with a wide blur is averaged over the pixels behind it.
// Where no direction has similar ends there is no structure to continue: all directions have equal similarity, their
// ends are averaged further, and the guess is smooth. Stripes would be wrong there, and would flicker during a focus
// pull.
//
// Words: a pixel of a layer is visible if nearer layers leave it open, and hidden if the layer must be guessed there
// (lib/hidden.lib.glsl). A block has 2 x 2 pixels. From a hidden pixel, each of four directions leads both ways to the
// next visible pixel, its two ends.
// More words: cost, squared difference of the two ends of a direction; similarity, 0 to 1, falls with the cost; listed,
// taken from a fragment list (with LISTS); known, the share of a pixel that needs no guess; structure_share, how far
// the guess follows the directions with similar ends, and smooth_share, how far it is smooth: together 1; line, all
// that is visible of a row or a column, which the guess follows behind wide things.
//
// Inputs
//   cost_tx           one channel a direction (hidden_cost.comp.glsl), NO_COST for visible blocks beside hidden ones
//   around_tx         with HIGHLIGHTS, for a layer in focus at full size: r luminance of the surroundings of highlights
//                     (highlight_split.comp.glsl)
//   bits_buf, words_buf   visible pixels (lib/visible_ends.lib.glsl)
//   two lists         the pixels to guess (hidden_blocks.comp.glsl)
//   listed_tx         with LISTS: r share known from lists, g depth in pixels behind the silhouette that the lens can
//                     see (layer_split.comp.glsl); as deep as that, lists are preferred to a guess
//   rows_steadiness_tx, columns_steadiness_tx   with LINES: r logarithm of the weight of a row and of a column, in nodes
//                     (lib/steadiness_system.lib.glsl)
//   coc_tx            r signed coc of the picture, read where a surface passes into the layer (lib/entering.lib.glsl)
//   match_tx          with MATCHED: the correction of their brightness (hidden_cost.comp.glsl)
// In and out; read at visible and hidden pixels, written at hidden ones
//   layer_img         rgb times coverage, a coverage. Before the pass, a of a hidden pixel is below 0 and packs its
//                     coverage and its known share: marked_cover and marked_known of lib/hidden.lib.glsl
//   state_tx and out_state_img: r diameter |coc| in pixels, g share of content, 0..1. They are one texture under two
//                     names, because Metal has no image of two floats that is read and written.

#include "lib/hidden_block.lib.glsl"  // MARK_WHOLE, neighbor_block, layer_size, PIXELS_PER_GROUP ...
#include "lib/highlight_limit.lib.glsl"  // highlight_share, dim, undim
#include "lib/layer.lib.glsl"  // solidity, has_weights, without_weight
#include "lib/entering.lib.glsl"  // is_entered, is_second_round, free_share_at, has_entering ...
#include "lib/visible_ends.lib.glsl"  // is_visible, is_beyond_reach, all_ends_of, hidden_mark, marked_known, marked_cover ...

layout(local_size_x = PIXELS_PER_GROUP) in;

uniform sampler2D cost_tx;
#ifdef HIGHLIGHTS
uniform sampler2D around_tx;
#endif
#ifdef LINES
uniform sampler2D rows_steadiness_tx;
uniform sampler2D columns_steadiness_tx;
uniform float near_steps;  // distance of an end, in steps of a line, at which it counts 1/e
uniform float near_power;  // the weight of a line grows with this power of what its ends count
#endif
layout(rgba32f) uniform image2D layer_img;
uniform sampler2D state_tx;
layout(rg32f) uniform writeonly image2D out_state_img;

// A listed surface has full weight up to a distance of LISTED_FROM from the next visible pixel, and none from LISTED_TO
// and one pixel on. Both are shares of the depth behind the silhouette that the lens can see (listed_tx).
#define LISTED_FROM 0.5
#define LISTED_TO 1.0
#define IN_FOCUS_TO 1.0        // |coc| in pixels up to which a surface is in focus
#define LEAST_SIMILARITY 1e-4  // added to the similarity: if no direction has similar ends the nearest decide
#define DISTANCE_POWER 2.0     // weights fall with this power of the distance between the ends
#define ALIKE_TO 0.4           // similarity of the best direction above which the guess follows structure
#define DULL_REACH 0.8         // share of the distance to an end that is averaged behind it where the guess is smooth
#define ONE_END_WEIGHT 0.02    // weight of an end without a partner: it gives color but no structure
#define DIAGONAL_LOSS 40.0     // how much less diagonals count where lines are followed, as a logarithm
#define LOG_OF_NONE (-69.0)    // logarithm of what an end counts that does not exist
#define LINE_BEHIND 0.6        // how far the pixels behind an end are averaged where lines are followed, in steps
#define MOST_SHOWN 0.85        // how far the nearer layer, which has the same surface, shows it at most: its guess is soft
#define LEAST_WEIGHT 0.06      // least weight of a guess: half floats hold the blur of a smaller one too roughly
#define BEHIND_REACH 0.26      // share of an end's diameter that is averaged behind it, with falling weight
#define BEHIND_MOST 64         // samples are 1, 2, 4 .. 32 pixels behind an end, each for its whole interval

const float STEP_LENGTH[HIDDEN_DIRECTIONS] = float[](1.0, 1.0, sqrt(2.0), sqrt(2.0));

struct Content {
    vec4 layer;      // rgb with highlights dimmed, times coverage, a coverage
    float diameter;  // |coc| in pixels, multiplied by coverage
    float weight;    // where a surface enters the farthest layer, the weight apart from the coverage; else 1
};

// The share of a pixel's color that is a highlight.
float highlight_share_at(vec3 color, ivec2 at) {
#ifdef HIGHLIGHTS
    return highlight_share(color, texelFetch(around_tx, at >> 1, 0).r);
#else
    return 0.0;
#endif
}

// The visible content of a pixel; a highlight is reduced to its surroundings, because it must not
// spread.
Content content_at(ivec2 at) {
    vec4 stored = imageLoad(layer_img, at), layer = is_entered ? without_weight(stored) : stored;
    vec3 color = layer.rgb / max(layer.a, 1e-4);
    color *= 1.0 - highlight_share_at(color, at);
    float weight = is_entered && has_weights() ? stored.a : 1.0;
    return Content(vec4(dim(color) * layer.a, layer.a), texelFetch(state_tx, at, 0).r * layer.a, weight);
}

// The cost of each direction, averaged over the 3 x 3 blocks around if `is_averaged`; NO_COST is left out. If
// not, the loop ends after its first block, and the result is not used.
vec4 mean_cost(ivec2 block, bool is_averaged) {
    vec4 sum = vec4(0.0), count = vec4(0.0);
    int i = 0;
    do {
        vec4 cost = texelFetch(cost_tx, neighbor_block(block, i), 0);
        vec4 counts = step(0.5 * NO_COST, cost);
        sum += counts * cost;
        count += counts;
    } while (is_averaged && ++i < 9);
    return sum / max(count, 1.0);
}

// Adds a content to a weighted sum.
void add(inout Content sum, inout float weights, float weight, Content c) {
    sum.layer += weight * c.layer;
    sum.diameter += weight * c.diameter;
    sum.weight += weight * c.weight;
    weights += weight;
}

// The mean of an end and the visible pixels behind it, over its own blur and at least `smooth_px`: a
// single texel must not fill the whole gap. `away_direction` points away from the hidden pixel.
Content end_at(ivec2 end, ivec2 away_direction, float step_px, float smooth_px, ivec2 size) {
    Content sum = content_at(end);
    float weights = 1.0, reach = max(max(BEHIND_REACH * sum.diameter, smooth_px) / step_px, 1e-3);
    int steps = 1;
    do {
        ivec2 p = end + steps * away_direction;
        if (float(steps) >= reach || p != clamp(p, ivec2(0), size - 1) || !is_visible(p, size)) continue;
        float relative_distance = float(steps) / reach, falloff = 1.0 - relative_distance * relative_distance;
        add(sum, weights, float(steps) * falloff * falloff * free_share_at(p), content_at(p));
    } while ((steps *= 2) < BEHIND_MOST && float(steps) < reach);
    return Content(sum.layer / weights, sum.diameter / weights, sum.weight / weights);
}

#ifdef LISTS
uniform sampler2D listed_tx;
#endif

#ifdef MATCHED
uniform sampler2D match_tx;

// The factor for listed light, averaged over the surrounding blocks.
vec3 match_at(ivec2 block) {
    vec4 sum = vec4(0.0);
    for (int i = 0; i < 9; ++i) {
        vec4 matched = texelFetch(match_tx, neighbor_block(block, i), 0);
        sum += max(matched.a, 0.0) * vec4(matched.rgb, 1.0);
    }
    return exp(sum.rgb / max(sum.a, 1e-9));
}
#endif

// The similarity of two ends, 0 to 1, by their squared difference.
float similarity_of(float cost) { return exp(-cost / (2.0 * ALIKE_VARIANCE)); }

struct Guess {
    float gap_px;    // distance to the nearest visible pixel
    vec4 layer;      // rgb times coverage, a coverage
    float diameter;  // |coc| in pixels
    float weight;    // that of Content
    float share;     // how far it counts; 1 in the first round
};

// Distance to the nearest end in pixels.
float nearest_of(ivec2 ends[HIDDEN_DIRECTIONS]) {
    float nearest = 1e30;
    for (int k = 0; k < HIDDEN_DIRECTIONS; ++k) {
        if (ends[k].x > 0) nearest = min(nearest, float(ends[k].x) * STEP_LENGTH[k]);
        if (ends[k].y > 0) nearest = min(nearest, float(ends[k].y) * STEP_LENGTH[k]);
    }
    return nearest;
}

// The share of the guess that is smooth: 0 if some direction has similar ends, 1 if none has.
float smooth_share_of(ivec2 ends[HIDDEN_DIRECTIONS], vec4 cost) {
    float most_similar = 0.0;
    for (int k = 0; k < HIDDEN_DIRECTIONS; ++k)
        if (min(ends[k].x, ends[k].y) > 0) most_similar = max(most_similar, similarity_of(cost[k]));
    return 1.0 - smoothstep(0.0, ALIKE_TO, most_similar);
}

struct EndWeights {
    vec2 weight;     // of the ends ahead and back; that of an end that does not exist means nothing
    vec2 smooth_px;  // how far the pixels behind each are averaged at least
};

// The weights of the two ends of direction k by their similarity and distance.
EndWeights weights_of(int k, ivec2 ends, float cost, float smooth_share) {
    vec2 ends_px = vec2(ends);
    float step_px = STEP_LENGTH[k], both_px = ends_px.x + ends_px.y;
    bool has_both = min(ends_px.x, ends_px.y) > 0.0;
    float similarity = has_both ? similarity_of(cost) + LEAST_SIMILARITY : ONE_END_WEIGHT;
    float length_px = (has_both ? 1.0 : 2.0) * both_px * step_px;
    // Raised to the power 0 where the guess is smooth, similarity does not count.
    float alike = pow(similarity, 1.0 - smooth_share) / pow(length_px, DISTANCE_POWER);
    vec2 smooth_px = has_both ? DULL_REACH * smooth_share * step_px * ends_px : vec2(0.0);
    return EndWeights(alike * (has_both ? ends_px.yx / both_px : vec2(1.0)), smooth_px);
}

#ifdef LINES
// The texel before a position along a row or a column, the one behind it, and the share of the latter.
struct Nodes {
    int low, high;
    float share;
};
Nodes nodes_at(int position, int length) {
    float at = max((float(position) + 0.5) / float(LINE_NODE) - 0.5, 0.0);
    return Nodes(int(at), min(int(at) + 1, (length - 1) / LINE_NODE), fract(at));
}

// The logarithms of the weights of the row and the column of a pixel, each between its two nearest nodes.
vec2 steadiness_at(ivec2 at) {
    Nodes row = nodes_at(at.x, layer_size.x), column = nodes_at(at.y, layer_size.y);
    vec2 low = vec2(texelFetch(rows_steadiness_tx, ivec2(row.low, at.y), 0).r,
                    texelFetch(columns_steadiness_tx, ivec2(at.x, column.low), 0).r);
    vec2 high = vec2(texelFetch(rows_steadiness_tx, ivec2(row.high, at.y), 0).r,
                     texelFetch(columns_steadiness_tx, ivec2(at.x, column.high), 0).r);
    return mix(low, high, vec2(row.share, column.share));
}

// Mixes the weights of direction k with those where the guess follows lines, by `share`. There only rows and columns
// count, by how steady they are and how near their ends, and a line with one end goes on too. Weights are mixed by
// their logarithms.
EndWeights with_lines(EndWeights by_ends, vec2 steadiness, int k, ivec2 ends, float share) {
    float line_px = float(max(line_step_px, 1));
    // Ends so far away that the exponential would be 0 count as none: the logarithm of 0 would make the guess not a number.
    vec2 log_near = mix(vec2(LOG_OF_NONE), -vec2(ends) / (near_steps * line_px), step(0.5, vec2(ends)));
    log_near = max(log_near, LOG_OF_NONE);
    vec2 log_line = log_near + (near_power - 1.0) * log(exp(log_near.x) + exp(log_near.y));
    log_line += k > 1 ? -DIAGONAL_LOSS : k == 0 ? steadiness.x : steadiness.y;
    vec2 weight = exp(mix(log(max(by_ends.weight, 1e-12)), log_line, share));
    return EndWeights(weight, mix(by_ends.smooth_px, vec2(LINE_BEHIND * line_px), share));
}
#endif

// Makes the guess for a pixel: the weighted mean of the ends of all directions. If no end is within reach, nothing is
// added; the loops end after one round, which costs less on a software rasterizer than a branch
// (lib/visible_ends.lib.glsl).
void make_guess(ivec2 at, ivec2 size, out Guess guess) {
    ivec2 ends[HIDDEN_DIRECTIONS] = all_ends_of(at, size);
    float line_share = line_share_of(ends[0], ends[1], reach_px);
    bool is_in_reach = !is_beyond_reach(ends) && (!is_second_round || has_entering(at, ends));
    vec4 cost = mean_cost(at >> 1, is_in_reach && line_share < 1.0);
    Content sum = Content(vec4(0.0), 0.0, 0.0);
    vec2 entering = vec2(0.0);
    float weights = 0.0, smooth_share = smooth_share_of(ends, cost);
#ifdef LINES
    vec2 steadiness = steadiness_at(at);
#endif
    int k = 0, directions = line_share < 1.0 ? HIDDEN_DIRECTIONS : 2;  // where lines alone decide, no diagonals
    do {
        EndWeights ends_weight = weights_of(k, ends[k], cost[k], smooth_share);
#ifdef LINES
        ends_weight = with_lines(ends_weight, steadiness, k, ends[k], line_share);
#endif
        vec2 smooth_px = ends_weight.smooth_px;
        float step_px = STEP_LENGTH[k];
        Content end_ahead = end_at(at + ends[k].x * DIRECTION[k], DIRECTION[k], step_px, smooth_px.x, size);
        Content end_back = end_at(at - ends[k].y * DIRECTION[k], -DIRECTION[k], step_px, smooth_px.y, size);
        entering += is_second_round ? entering_of(at, k, ends[k], ends_weight.weight) : vec2(0.0);
        if (is_in_reach && ends[k].x > 0) add(sum, weights, ends_weight.weight.x, end_ahead);
        if (is_in_reach && ends[k].y > 0) add(sum, weights, ends_weight.weight.y, end_back);
    } while (is_in_reach && ++k < directions);
    guess = Guess(nearest_of(ends), vec4(0.0), 0.0, 0.0, is_second_round ? 0.0 : 1.0);
    if (weights == 0.0) {    // no pixel of this layer is visible near enough in any direction
        guess.gap_px = 0.0;  // lists are used alone
        return;
    }
    float cover = sum.layer.a / weights;  // mean coverage or weight, by which colors and diameters are divided
    float per_cover = 1.0 / max(sum.layer.a, 1e-4 * weights);
    if (is_second_round) guess.share = share_of_entering(entering, MOST_SHOWN * entering.y / weights);
    guess.layer = vec4(undim(sum.layer.rgb * per_cover) * cover, cover);
    guess.diameter = sum.diameter * per_cover;
    guess.weight = sum.weight / weights;
}

// The guess, mixed with what the pixel has of its own. In the second round, its own is the first guess: colors are mixed
// by the share of the second guess, which counts with the weight of all ends.
vec4 mix_with_guess(vec4 own, Guess guess, float known) {
    vec4 second = mix(guess.layer, without_weight(own), known) * guess.weight;
    bool is_weighted = is_second_round && has_weights() && guess.share > 0.0;
    return is_weighted ? second : mix(guess.layer * guess.weight, own, known);
}

// Writes a pixel: the guess, mixed with what is known of the pixel itself (own).
void fill_pixel(ivec2 at, Guess guess) {
    vec4 own = imageLoad(layer_img, at);
    vec2 state = texelFetch(state_tx, at, 0).rg;
    float known = max(marked_known(own.a), 1.0 - guess.share);  // in the second round, the pixel has its first guess
    if (is_second_round && marked_cover(own.a) == 0.0 && guess.share > 0.0) known = 0.0;  // there was nothing to guess from
    bool is_kept = is_entered && !is_second_round && known == 0.0;
    own.a = marked_cover(own.a);
#ifdef LISTS
    vec2 listed = texelFetch(listed_tx, at, 0).rg;
#ifdef MATCHED
    own.rgb *= mix(vec3(1.0), match_at(at >> 1), listed.r / max(listed.r + known, 1e-6));
#endif
    // out_of_sight: 0 where the lens can see the listed surface, 1 so far behind the silhouette that it cannot. A surface
    // in focus is in its place there too, but without highlights: they would shine through a coverage of nearly 1.
    float out_of_sight = smoothstep(LISTED_FROM * listed.g, LISTED_TO * listed.g + 1.0, guess.gap_px);
    own.rgb *= 1.0 - out_of_sight * highlight_share_at(own.rgb / max(own.a, 1e-4), at);
    out_of_sight *= smoothstep(IN_FOCUS_TO, 3.0 * IN_FOCUS_TO, state.r);
    known = min(known + listed.r * (1.0 - out_of_sight), 1.0);
#endif
    vec4 layer = mix_with_guess(own, guess, known);
    if (has_weights() && layer.a > 0.0) layer *= max(LEAST_WEIGHT / layer.a, 1.0);
    float own_weight = known * own.a, guess_weight = (1.0 - known) * guess.layer.a;
    float diameter = (own_weight * state.r + guess_weight * guess.diameter) / max(own_weight + guess_weight, 1e-6);
    float content = mix(solidity(without_weight(guess.layer).a), state.g, known);
    if (is_kept) layer.a = hidden_mark(layer.a, 0.0);
    imageStore(layer_img, at, layer);
    imageStore(out_state_img, at, vec4(diameter, content, 0.0, 0.0));
}

// Fills a listed pixel, or all four of a listed block.
void fill_listed(uint listed) {
    ivec2 hidden = pixel_of_word(listed);
    bool is_block = listed >= MARK_WHOLE;
    Guess guess;
    make_guess(hidden, layer_size, guess);
    int i = 0;
    do fill_pixel(hidden + ivec2(i & 1, i >> 1), guess); while (is_block && ++i < 4);
}

void main() { FOR_EACH_IN_BOTH(fill_listed) }

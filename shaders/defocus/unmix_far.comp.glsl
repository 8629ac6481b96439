// Splits each far edge pixel into its two surfaces. The far color comes from pixels of the far surface alone, the near
// color from nearer neighbors. The coverage of the near surface follows from where the pixel's color lies between
// both.
//
// Words (lib/kind.lib.glsl): at a silhouette, a far edge pixel is one whose depth sample hit the far surface while the
// color of the nearer surface is mixed in; a near edge pixel is one whose sample hit the near surface while the color
// of the farther one shines through. Each of the two surfaces in such a pixel has its own color, coverage (share of the
// pixel) and coc (signed circle of confusion, diameter in pixels, negative in front of the focus).
//
// Inputs
//   color_tx, coc_tx, kind_tx   color, coc and kind of each pixel
//   two lists     the first has all far edge pixels, the second all near edge pixels
//   with LISTS: fragment lists, which know the far surface also behind its nearer neighbors
// In and out; near edge pixels are only read, far edge pixels only written
//   far_img       near edge, before: rgb own color, a OWN_FOUND or more if there is one (unmix_own.comp.glsl)
//                 far edge, after: rgb of the far surface, a coverage of the near surface
//   near_img      near edge, before: rgb rounding error of the own color, to be added to it
//                 far edge, after: rgb of the near surface, a its coc
// Output
//   pixel list    the far edges that may be those of hair (unmix_thin.comp.glsl)

#include "lib/focus_offset.lib.glsl"  // for lib/fragment_list.lib.glsl
#include "lib/bit_search.lib.glsl"  // lowest_bit
#include "lib/two_lists.lib.glsl"  // FOR_EACH_IN_FIRST, pixel_of_word, PIXELS_PER_GROUP
#include "lib/pixel_list.lib.glsl"  // list_append
#include "lib/unmix.lib.glsl"  // HALF_MAX, OWN_FOUND, color_at, kind_at, unmix_share, ends_beside, FAR_EDGE ...
#include "lib/outline.lib.glsl"  // outline_share
#ifdef LISTS
#include "lib/known_behind.lib.glsl"  // hidden_surface
#endif
#include "lib/tone.lib.glsl"  // compress_light, expand_light

layout(local_size_x = PIXELS_PER_GROUP) in;

layout(rgba16f) uniform image2D far_img;
layout(rgba16f) uniform image2D near_img;
#define FAR_EDGE_WEIGHT 0.1  // weight of a near neighbor that is itself a far edge
#define MOST_COVERAGE 0.5   // largest coverage: depth is sampled at the pixel's center and missed the near surface
#define LEAST_SHARE 0.02    // least coverage to divide by (THIN in lib/layer.lib.glsl)
#define LEAST_VISIBLE 0.2   // least visible share of the far surface to divide by
#define DETAIL_FROM 0.3     // visible share of the far surface from which it keeps some of its detail
#define DETAIL_FULL 0.7     // visible share from which it keeps all of it
#define BEYOND 12           // pixels to which the far surface is looked for where none of it is unmixed nearby
#define TAKEN_FROM 0.3      // share of the near color from which such a pixel shows too little of the far surface
#define TAKEN_FULL 0.6      // share from which it counts for nothing
#define SPREADS 2.0         // standard deviations by which the far color may differ from known ones around it
#define LEAST_SPREAD 0.03   // added to them, of compressed light
#define FAR_SIDE 5          // side of the searched square in pixels: across a wire's far edge to an unmixed pixel

struct FarSide {
    vec3 mean;       // compressed color
    float variance;
    float weight;    // 0 if nothing was found
    bool is_known;   // the lists had some of it
};

// Adds a color (a is its weight) to the sums of weighted colors and of weighted squared colors. The weight is
// divided by distance^6.
void add_sample(inout vec4 sum, inout vec3 squares, vec4 weighted_color, ivec2 pixel_offset) {
    float distance_2 = float(pixel_offset.x * pixel_offset.x + pixel_offset.y * pixel_offset.y);
    weighted_color.a /= distance_2 * distance_2 * distance_2;
    sum += weighted_color.a * vec4(weighted_color.rgb, 1.0);
    squares += weighted_color.a * weighted_color.rgb * weighted_color.rgb;
}

// The offset of pixel i of the searched square from its center.
ivec2 offset_of(int i) { return ivec2(i % FAR_SIDE, i / FAR_SIDE) - FAR_SIDE / 2; }

// Mean color of the unmixed pixels around that show the far surface, whose coc is `coc`. Weights fall so steeply with
// distance that the nearest pixels in the row and column decide: detail of the far side is kept.
FarSide far_side(ivec2 at, float coc) {
    vec4 sum = vec4(0.0);
    vec3 squares = vec3(0.0);
    uint nearer = 0u;  // bits of nearer pixels, whose lists may have the surface; they are searched last
    int i = 0;
    do {
        ivec2 p = inside(at + offset_of(i));
        float other = coc_at(p);
        if (kind_at(p) == FAR_EDGE || is_in_front(coc, other)) continue;
        if (is_in_front(other, coc)) nearer |= 1u << i;
        else add_sample(sum, squares, vec4(compress_light(color_at(p)), 1.0), offset_of(i));
    } while (++i < FAR_SIDE * FAR_SIDE);
    bool is_known = false;
#ifdef LISTS
    while (nearer != 0u) {
        ivec2 pixel_offset = offset_of(lowest_bit(nearer));
        vec4 hidden = hidden_surface(inside(at + pixel_offset), coc);
        is_known = is_known || hidden.a > 0.0;
        add_sample(sum, squares, vec4(compress_light(hidden.rgb), hidden.a), pixel_offset);
        nearer &= nearer - 1u;
    }
#endif
    float weights = max(sum.a, 1e-9);
    return FarSide(sum.rgb / weights, variance_of(sum.rgb / weights, squares / weights), sum.a, is_known);
}

#ifdef LISTS
// Limits a color of the far side to those that are known around it. What exceeds them is light of the near side, as of
// a bright edge of a wire, whose color is taken from pixels beside the edge.
vec3 within_spread(vec3 color, FarSide side) {
    float spread = SPREADS * sqrt(side.variance / 3.0) + LEAST_SPREAD;
    return expand_light(clamp(compress_light(color), max(side.mean - spread, 0.0), side.mean + spread));
}
#endif

// Compressed color of the far surface where none of it is unmixed nearby, as in a gap of a pixel between two stems; a its
// weight, 0 if nothing was found. In each of eight directions, the first unmixed pixel of the surface counts by its
// squared distance. If not `is_needed`, the loop ends after one round and the result is not used.
vec4 far_beyond(ivec2 at, float coc, bool is_needed) {
    vec4 sum = vec4(0.0);
    int direction = 0, distance = FAR_SIDE / 2;
    do {
        ivec2 step_px = ivec2(direction % 3, direction / 3) - 1, p = inside(at + ++distance * step_px);
        float other = coc_at(p);
        bool is_found = kind_at(p) != FAR_EDGE && !is_in_front(coc, other) && !is_in_front(other, coc);
        vec2 moved = vec2(distance * step_px);
        if (is_found && direction != 4) sum += vec4(compress_light(color_at(p)), 1.0) / max(dot(moved, moved), 1.0);
        if (!is_found && distance < BEYOND && direction != 4) continue;
        ++direction;
        distance = FAR_SIDE / 2;
    } while (is_needed && direction < 9);
    return sum;
}

// True unless most of the nearer surfaces beside the pixel are only one or two pixels wide.
bool are_most_wide(ivec2 at, float coc) {
    int nearer = 0, thin = 0;
    for (int k = 0; k < 9; ++k) {
        nearer += int(is_in_front(coc_at(neighbor(at, k)), coc));
        thin += int(ends_in(at, k, coc));
    }
    return 2 * thin <= nearer;
}

// Least coc among the neighbors in front of the pixel; its own coc if there are none.
float nearest_around(ivec2 at, float coc) {
    float nearest = coc;
    for (int k = 0; k < 9; ++k) {
        float other = coc_at(neighbor(at, k));
        if (is_in_front(other, coc)) nearest = min(nearest, other);
    }
    return nearest;
}

// Mean color of the neighbors on the nearest surface; a its mean coc. Far edges among them count less, because their
// color is mixed.
vec4 near_side(ivec2 at, float coc) {
    float nearest = nearest_around(at, coc);
    vec4 sum = vec4(0.0);
    float weights = 0.0;
    int k = 0;
    do {
        ivec2 p = neighbor(at, k);
        float other = coc_at(p), kind = kind_at(p);
        if (!is_in_front(other, coc) || !is_same_surface(other, nearest)) continue;
        vec4 own = imageLoad(far_img, p);
        bool is_own = kind == NEAR_EDGE && own.a >= OWN_FOUND;
        vec3 color = is_own ? own.rgb + imageLoad(near_img, p).rgb : color_at(p);
        float weight = kind == FAR_EDGE ? FAR_EDGE_WEIGHT : 1.0;
        sum += weight * vec4(color, other);
        weights += weight;
    } while (++k < 9);
    return sum / weights;
}

// Splits a listed far edge pixel into its two surfaces.
void split_far(uint word) {
    ivec2 at = pixel_of_word(word);
    set_center(at);
    float coc = coc_at(at);
    if (ends_beside(at, coc)) list_append(at);
    vec3 x = color_at(at), far = x;  // x is the mixed color of the pixel
    FarSide unmixed = far_side(at, coc);
    vec4 near = near_side(at, coc);
    if (unmixed.weight > 0.0) far = expand_light(unmixed.mean);
    // Between hairs, the pixel itself shows more of what is behind them than pixels far from it do.
    bool is_gap = unmixed.weight == 0.0 && are_most_wide(at, coc);
    vec4 beyond = far_beyond(at, coc, is_gap);
    if (is_gap && beyond.a > 0.0) {
        vec3 other = beyond.rgb / beyond.a, mixed = compress_light(x), step_to = compress_light(near.rgb) - other;
        float taken = dot(mixed - other, step_to) / max(dot(step_to, step_to), 1e-6);
        far = mix(x, expand_light(other), smoothstep(TAKEN_FROM, TAKEN_FULL, taken));
    }
    float coverage = coverage_of(x, near.rgb, far, unmixed.variance, 1.0 - outline_share(at, coc, true));
    coverage = clamp(coverage, 0.0, MOST_COVERAGE);
    // The residual of the mix is detail of the far side, weighted by how much of it is visible. A pixel in a narrow gap may
    // show little else than the near side.
    float visible = 1.0 - coverage, detail = smoothstep(DETAIL_FROM, DETAIL_FULL, visible);
    vec3 residual = (x - far - coverage * (near.rgb - far)) / max(visible, LEAST_VISIBLE);
    far = max(far + detail * residual, 0.0);
#ifdef LISTS
    if (unmixed.is_known) far = within_spread(far, unmixed);
#endif
    vec3 own = max(x - visible * far, 0.0) / max(coverage, LEAST_SHARE);
    near.rgb = mix(own, near.rgb, unmix_share(near.a));  // in focus, both together are the pixel
    imageStore(far_img, at, vec4(min(far, HALF_MAX), coverage));
    imageStore(near_img, at, vec4(min(near.rgb, HALF_MAX), near.a));
}

void main() { FOR_EACH_IN_FIRST(split_far) }

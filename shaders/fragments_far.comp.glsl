// Splits each far rim pixel into two fragments: the far colour comes from the far side alone, the near
// colour from its nearer neighbours; where the pixel's colour lies between them gives the coverage.
//
// Inputs
//   color_tx, coc_tx, kind_tx, pixel list    as fragments_find.comp.glsl leaves them
//   with LISTS: fragment lists, which know the far surface also behind its nearer neighbours
// Outputs (far rim only)
//   out_far_img   rgb of the far fragment, a coverage of the near one
//   out_near_img  rgb of the near fragment, a its signed coc
// Output (both rims)
//   thin list     the rims that may be those of hair, for fragments_thin.comp.glsl

#include "lib/lean.lib.glsl"
#ifdef LISTS
#include "lib/fragment_list.lib.glsl"
#endif
#include "lib/pixel_list.lib.glsl"
#include "lib/rim.lib.glsl"
#include "lib/tone.lib.glsl"

layout(local_size_x = PIXELS_PER_GROUP) in;

layout(rgba16f) uniform writeonly image2D out_far_img;
layout(rgba16f) uniform writeonly image2D out_near_img;
layout(std430) buffer thin_list_block {
    uint thin_groups[3];
    uint thin_count;
    uint thin_pixels[];  // y << 16 | x, see lib/pixel_list.lib.glsl
};

void append_thin(ivec2 at) {
    uint slot = atomicAdd(thin_count, 1u);
    bool opens_group = slot % PIXELS_PER_GROUP == 0u && slot / PIXELS_PER_GROUP < GROUPS_MAX;
    if (opens_group) atomicAdd(thin_groups[0], 1u);
    thin_pixels[slot] = uint(at.y) << 16 | uint(at.x);
}

#define FAR_RIM_WEIGHT 0.1  // weight of a near neighbour that is itself beside something nearer
#define MOST_COVERAGE 0.5   // depth was sampled at the pixel's centre and missed the near surface
#define KNOWN_FROM_PX 1.5   // of less blur, what is seen beside it shows as sharply, and is nearer
#define LEAST_SHARE 0.02    // smaller ones do not count (THIN in lib/layer.lib.glsl)
#define FAR_SIDE 5          // pixels: across a wire's far rim to the next unmixed pixel

// Compressed colour of the far surface where a nearer pixel hides it; a = its weight.
vec4 known_behind(ivec2 at, float coc) {
#ifdef LISTS
    List list = list_at(at);
    if (abs(coc) < KNOWN_FROM_PX || list.has_front) return vec4(0.0);
    for (uint i = list.first; i < list.end; ++i) {
        Fragment f = fragment_of(i);
        if (is_same_surface(coc, f.coc)) return vec4(toned(f.color), f.cover);
    }
#endif
    return vec4(0.0);
}

struct FarSide {
    vec3 mean;       // compressed
    float variance;
    float weight;    // 0 if nothing was found
};

// Mean of the whole pixels around on the far surface. Weights fall so steeply that the next ones in the
// row and column decide: detail of the far side is kept.
FarSide far_side(ivec2 at, float coc) {
    vec4 sum = vec4(0.0);
    vec3 squares = vec3(0.0);
    int i = 0;
    do {
        ivec2 aside = ivec2(i % FAR_SIDE, i / FAR_SIDE) - FAR_SIDE / 2, p = inside(at + aside);
        float other = coc_at(p), distance_2 = float(aside.x * aside.x + aside.y * aside.y);
        if (kind_at(p) == FAR_RIM || is_in_front(coc, other)) continue;
        vec4 found = is_in_front(other, coc) ? known_behind(p, coc) : vec4(toned(color_at(p)), 1.0);
        found.a /= distance_2 * distance_2 * distance_2;
        sum += found.a * vec4(found.rgb, 1.0);
        squares += found.a * found.rgb * found.rgb;
    } while (++i < FAR_SIDE * FAR_SIDE);
    float whole = max(sum.a, 1e-9);
    return FarSide(sum.rgb / whole, variance_of(sum.rgb / whole, squares / whole), sum.a);
}

float nearest_around(ivec2 at, float coc) {
    float nearest = coc;
    for (int k = 0; k < 9; ++k) {
        float other = coc_at(neighbour(at, k));
        if (is_in_front(other, coc)) nearest = min(nearest, other);
    }
    return nearest;
}

// Mean colour of the neighbours on the nearest surface; a its mean coc.
vec4 near_side(ivec2 at, float coc) {
    float nearest = nearest_around(at, coc);
    vec4 sum = vec4(0.0);
    float weights = 0.0;
    int k = 0;
    do {
        ivec2 p = neighbour(at, k);
        float other = coc_at(p), kind = kind_at(p);
        if (!is_in_front(other, coc) || !is_same_surface(other, nearest)) continue;
        vec3 color;
        if (kind != NEAR_RIM || !unmixed_near(p, color)) color = color_at(p);
        float weight = kind == FAR_RIM ? FAR_RIM_WEIGHT : 1.0;
        sum += weight * vec4(color, other);
        weights += weight;
    } while (++k < 9);
    return sum / weights;
}

// Half the share that a box filter over the depth outline sees as nearer: 1/8 beside a straight edge,
// which is the mean true coverage there.
float outline_coverage(ivec2 at, float coc) {
    float nearer = 0.0;
    for (int k = 0; k < 9; ++k)
        if (is_in_front(coc_at(neighbour(at, k)), coc)) nearer += 0.5 * OUTLINE_WEIGHT[k];
    return nearer;
}

// Lists a rim that may be beside, or on, something nearer that ends again after one or two pixels.
void list_thin(ivec2 at, float coc) {
    vec3 own;
    bool is_far = kind_at(at) == FAR_RIM;
    bool may_be = is_far ? ends_beside(at, coc) : abs(coc) > SPLIT_FROM_PX && !unmixed_near(at, own);
    if (may_be) append_thin(at);
}

void split_far(ivec2 at) {
    stand_at(at);
    float coc = coc_at(at);
    list_thin(at, coc);
    if (kind_at(at) != FAR_RIM) return;
    vec3 x = color_at(at), far = x;
    FarSide unmixed = far_side(at, coc);
    vec4 near = near_side(at, coc);
    if (unmixed.weight > 0.0) far = untoned(unmixed.mean);
    float coverage = coverage_of(x, near.rgb, far, unmixed.variance, outline_coverage(at, coc));
    coverage = clamp(coverage, 0.0, MOST_COVERAGE);
    // The residual of the mix is detail of the far side, weighted by how much of it is visible.
    float seen = 1.0 - coverage;
    vec3 rest = (x - far - coverage * (near.rgb - far)) / max(seen, 0.2);
    far = max(far + smoothstep(0.3, 0.7, seen) * rest, 0.0);
    vec3 own = max(x - seen * far, 0.0) / max(coverage, LEAST_SHARE);
    near.rgb = mix(own, near.rgb, unmixed_part(near.a));  // in focus, both together are the pixel
    imageStore(out_far_img, at, vec4(min(far, HALF_MAX), coverage));
    imageStore(out_near_img, at, vec4(min(near.rgb, HALF_MAX), near.a));
}

void main() { FOR_EACH_LISTED(split_far) }

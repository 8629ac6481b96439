// Splits each far rim pixel into two fragments: the far colour comes from the far side alone, the near
// colour from its nearer neighbours; where the pixel's colour lies between them gives the coverage.
//
// Inputs
//   color_tx, coc_tx, kind_tx, two lists    as fragments_find.comp.glsl leaves them
//   with LISTS: fragment lists, which know the far surface also behind its nearer neighbours
// Read on the near rim, as fragments_own.comp.glsl leaves them; written on the far rim
//   far_img       rgb of the far fragment, a coverage of the near one
//   near_img      rgb of the near fragment, a its signed coc
// Output (far rim only)
//   thin list     the rims that may be those of hair

#include "lib/lean.lib.glsl"
#ifdef LISTS
#include "lib/fragment_list.lib.glsl"
#endif
#include "lib/two_lists.lib.glsl"
#include "lib/pixel_list.lib.glsl"
#include "lib/rim.lib.glsl"
#include "lib/tone.lib.glsl"

layout(local_size_x = PIXELS_PER_GROUP) in;

layout(rgba16f) uniform image2D far_img;
layout(rgba16f) uniform image2D near_img;
#define FAR_RIM_WEIGHT 0.1  // weight of a near neighbour that is itself beside something nearer
#define MOST_COVERAGE 0.5   // depth was sampled at the pixel's centre and missed the near surface
#define KNOWN_FROM_PX 1.5   // of less blur, what is seen beside it shows as sharply, and is nearer
#define LEAST_SHARE 0.02    // smaller ones do not count (THIN in lib/layer.lib.glsl)
#define FAR_SIDE 5          // pixels: across a wire's far rim to the next unmixed pixel

#ifdef LISTS
// Compressed colour of the far surface where a nearer pixel hides it; a = its weight.
vec4 known_behind(ivec2 at, float coc) {
    List list = list_at(at);
    vec4 found = vec4(0.0);
    bool is_sought = !list.has_front && list.first < list.end;
    uint i = list.first;
    do {
        Fragment f = fragment_of(i);
        bool is_it = is_sought && is_same_surface(coc, f.coc);
        found += is_it ? vec4(toned(f.color), f.cover) : vec4(0.0);
        is_sought = is_sought && !is_it;
    } while (is_sought && ++i < list.end);
    return found;
}
#endif

struct FarSide {
    vec3 mean;       // compressed
    float variance;
    float weight;    // 0 if nothing was found
};

void add_found(inout vec4 sum, inout vec3 squares, vec4 found, ivec2 aside) {
    float distance_2 = float(aside.x * aside.x + aside.y * aside.y);
    found.a /= distance_2 * distance_2 * distance_2;
    sum += found.a * vec4(found.rgb, 1.0);
    squares += found.a * found.rgb * found.rgb;
}

ivec2 aside_of(int i) { return ivec2(i % FAR_SIDE, i / FAR_SIDE) - FAR_SIDE / 2; }

// Mean of the whole pixels around on the far surface. Weights fall so steeply that the next ones in the
// row and column decide: detail of the far side is kept.
FarSide far_side(ivec2 at, float coc) {
    vec4 sum = vec4(0.0);
    vec3 squares = vec3(0.0);
    uint nearer = 0u;  // those that may have it in their lists are looked at last, because that takes longer
    int i = 0;
    do {
        ivec2 p = inside(at + aside_of(i));
        float other = coc_at(p);
        if (kind_at(p) == FAR_RIM || is_in_front(coc, other)) continue;
        if (is_in_front(other, coc)) nearer |= 1u << i;
        else add_found(sum, squares, vec4(toned(color_at(p)), 1.0), aside_of(i));
    } while (++i < FAR_SIDE * FAR_SIDE);
#ifdef LISTS
    if (abs(coc) < KNOWN_FROM_PX) nearer = 0u;
    while (nearer != 0u) {
        ivec2 aside = aside_of(findLSB(nearer));
        add_found(sum, squares, known_behind(inside(at + aside), coc), aside);
        nearer &= nearer - 1u;
    }
#endif
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
        vec4 own = imageLoad(far_img, p);
        bool is_own = kind == NEAR_RIM && own.a == OWN_FOUND;
        vec3 color = is_own ? own.rgb + imageLoad(near_img, p).rgb : color_at(p);
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

void split_far(uint word) {
    ivec2 at = pixel_of_word(word);
    stand_at(at);
    float coc = coc_at(at);
    if (ends_beside(at, coc)) list_append(at);
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
    imageStore(far_img, at, vec4(min(far, HALF_MAX), coverage));
    imageStore(near_img, at, vec4(min(near.rgb, HALF_MAX), near.a));
}

void main() { FOR_EACH_IN_FRONT(split_far) }

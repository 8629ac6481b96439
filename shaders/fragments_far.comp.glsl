// Splits each far rim pixel into two fragments: the far colour comes from the far side alone, the near
// colour from its nearer neighbours; where the pixel's colour lies between them gives the coverage.
//
// Inputs
//   color_tx, coc_tx, kind_tx, pixel list    as fragments_find.comp.glsl leaves them
// Outputs (far rim only)
//   out_far_img   rgb of the far fragment, a coverage of the near one
//   out_near_img  rgb of the near fragment, a its signed coc

#include "lib/pixel_list.lib.glsl"
#include "lib/rim.lib.glsl"
#include "lib/tone.lib.glsl"

layout(local_size_x = PIXELS_PER_GROUP) in;

layout(rgba16f) uniform writeonly image2D out_far_img;
layout(rgba16f) uniform writeonly image2D out_near_img;

#define FAR_RIM_WEIGHT 0.1  // weight of a near neighbour that is itself beside something nearer
#define FAR_REACH 2         // pixels: across a wire's far rim to the next unmixed pixel

// Mean of the whole pixels around on the far surface, compressed; a = their weight. Weights fall so
// steeply that the next ones in the row and column decide: detail of the far side is kept.
vec4 far_side(ivec2 at, float coc) {
    vec4 sum = vec4(0.0);
    for (int y = -FAR_REACH; y <= FAR_REACH; ++y)
        for (int x = -FAR_REACH; x <= FAR_REACH; ++x) {
            ivec2 p = inside(at + ivec2(x, y));
            float other = coc_at(p), distance_2 = float(x * x + y * y);
            if (is_in_front(other, coc) || is_in_front(coc, other) || kind_at(p) == FAR_RIM) continue;
            sum += vec4(toned(color_at(p)), 1.0) / (distance_2 * distance_2 * distance_2);
        }
    return sum;
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
    for (int k = 0; k < 9; ++k) {
        ivec2 p = neighbour(at, k);
        float other = coc_at(p), kind = kind_at(p);
        if (!is_in_front(other, coc) || !is_same_surface(other, nearest)) continue;
        vec3 color;
        if (kind != NEAR_RIM || !unmixed_near(p, color)) color = color_at(p);
        float weight = kind == FAR_RIM ? FAR_RIM_WEIGHT : 1.0;
        sum += weight * vec4(color, other);
        weights += weight;
    }
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

void split_far(ivec2 at) {
    if (kind_at(at) != FAR_RIM) return;
    float coc = coc_at(at);
    vec3 x = color_at(at), far = x;
    vec4 unmixed = far_side(at, coc), near = near_side(at, coc);
    if (unmixed.a > 0.0) far = untoned(unmixed.rgb / unmixed.a);
    float coverage = clamp(coverage_of(x, near.rgb, far, outline_coverage(at, coc)), 0.0, 1.0);
    // The residual of the mix is detail of the far side, weighted by how much of it is visible.
    float seen = 1.0 - coverage;
    vec3 rest = (x - far - coverage * (near.rgb - far)) / max(seen, 0.2);
    far = max(far + smoothstep(0.3, 0.7, seen) * rest, 0.0);
    imageStore(out_far_img, at, vec4(min(far, HALF_MAX), coverage));
    imageStore(out_near_img, at, vec4(min(near.rgb, HALF_MAX), near.a));
}

void main() { FOR_EACH_LISTED(split_far) }

// Finds where one surface ends in front of another, from the circle of confusion alone: it is linear
// in 1/z, so differences and ratios of 1/z are those of coc - infinity_px, once `stand_at` was called.

#include "lib/kind.lib.glsl"
#include "lib/lean.lib.glsl"

uniform sampler2D coc_tx;
uniform float at_infinity_px;  // signed coc of a point infinitely far away, in the middle of the picture

float infinity_px;  // the same at a pixel

void stand_at(ivec2 at) { infinity_px = at_infinity_px + lean_at(at); }

#define JUMP_PX 3.0        // a smaller step in coc may be a slanted surface
#define DEPTH_RATIO 0.95   // depths within this ratio are the same surface
#define PRIOR_WEIGHT 0.01  // colour contrast^2 below which coverage comes from the depth's outline,
#define PRIOR_GAIN 32.0    // added per variance of the far colours: if they vary, one of them is a guess

// Weights of a box-filtered edge as seen from 3 x 3 depth samples; they sum to 1.
const float OUTLINE_WEIGHT[9] =
    float[](0.0625, 0.125, 0.0625, 0.125, 0.25, 0.125, 0.0625, 0.125, 0.0625);

ivec2 inside(ivec2 at) { return clamp(at, ivec2(0), textureSize(coc_tx, 0) - 1); }
ivec2 neighbour(ivec2 at, int k) { return inside(at + ivec2(k % 3, k / 3) - 1); }  // k 0..8
float coc_at(ivec2 at) { return texelFetch(coc_tx, inside(at), 0).r; }
float inverse_depth(float coc) { return infinity_px - coc; }  // up to a factor

bool is_in_front(float coc, float of) {
    return abs(coc - of) > JUMP_PX && inverse_depth(coc) * DEPTH_RATIO > inverse_depth(of);
}

bool is_same_surface(float coc, float other) {
    float a = inverse_depth(coc), b = inverse_depth(other);
    return min(a, b) >= DEPTH_RATIO * max(a, b);
}

float variance_of(vec3 mean, vec3 mean_square) { return dot(max(mean_square - mean * mean, 0.0), vec3(1.0)); }

// Least-squares coverage a of `near` in x = a near + (1 - a) far; the prior, where there is little
// contrast for the variance of the far colours around.
float coverage_of(vec3 x, vec3 near, vec3 far, float variance, float prior) {
    vec3 across = near - far;
    float weight = PRIOR_WEIGHT + PRIOR_GAIN * variance;
    return (dot(x - far, across) + weight * prior) / (dot(across, across) + weight);
}

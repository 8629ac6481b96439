// Finds edges of one surface in front of another (silhouettes) from the circle of confusion (coc) alone. The coc is
// linear in 1 / depth: differences and ratios of 1 / depth are those of infinity_px - coc, where infinity_px is the coc
// at infinity. Call `set_center` first.
//
// A number k from 0 to 8 is one of the 3 x 3 pixels around a pixel, row by row; 4 is the pixel itself.

#include "lib/kind.lib.glsl"  // for the files that include this one
#include "lib/focus_offset.lib.glsl"  // focus_offset_at

uniform sampler2D coc_tx;      // signed coc, pixels
uniform float at_infinity_px;  // signed coc of a point infinitely far away, in the middle of the picture

float infinity_px;  // signed coc of a point infinitely far away at the pixel of `set_center`

// Sets the pixel at which surfaces are compared.
void set_center(ivec2 at) { infinity_px = at_infinity_px + focus_offset_at(at); }

#define JUMP_PX 3.0        // least difference in coc between two surfaces; a smaller one may be a slanted surface
#define DEPTH_RATIO 0.95   // ratio of the nearer depth to the farther, from which both are of one surface
#define PRIOR_WEIGHT 0.01  // color contrast^2 below which the coverage is mainly the prior, which is that of the depths
#define PRIOR_GAIN 32.0    // added to it, times the variance of the far colors: if they vary, the far color is a guess

// The pixel of the picture that is nearest to a position.
ivec2 inside(ivec2 at) { return clamp(at, ivec2(0), textureSize(coc_tx, 0) - 1); }
ivec2 neighbor(ivec2 at, int k) { return inside(at + ivec2(k % 3, k / 3) - 1); }  // k 0..8
float coc_at(ivec2 at) { return texelFetch(coc_tx, inside(at), 0).r; }
float inverse_depth(float coc) { return infinity_px - coc; }  // 1 / depth, up to a factor

// True if a surface with this coc is in front of one with coc `of`, and is another surface.
bool is_in_front(float coc, float of) {
    return abs(coc - of) > JUMP_PX && inverse_depth(coc) * DEPTH_RATIO > inverse_depth(of);
}

// True if two pixels may show the same surface.
bool is_same_surface(float coc, float other) {
    float a = inverse_depth(coc), b = inverse_depth(other);
    return min(a, b) >= DEPTH_RATIO * max(a, b);
}

// Sum of the variances of red, green and blue, from their means and mean squares.
float variance_of(vec3 mean, vec3 mean_square) { return dot(max(mean_square - mean * mean, 0.0), vec3(1.0)); }

// The coverage a of `near` in the mixed color x = a near + (1 - a) far, by least squares. With little contrast between
// `near` and `far`, relative to the variance of the far colors around, it tends to `prior`.
float coverage_of(vec3 x, vec3 near, vec3 far, float variance, float prior) {
    vec3 across = near - far;
    float weight = PRIOR_WEIGHT + PRIOR_GAIN * variance;
    return (dot(x - far, across) + weight * prior) / (dot(across, across) + weight);
}

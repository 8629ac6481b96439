// Blurs by a pyramid: interpolates each pixel between the two levels whose blur is just below and just above its own
// (trilinear, Williams 1983).
//
// A disc of diameter d has the variance d^2 / 16 along each axis. A level that is read linearly has a blur of variance
// (4^level - 1) / 2 px^2 along each axis: the filter of pyramid_reduce.comp.glsl adds 1 at each level, in that level's
// pixels, and interpolation (4^level - 1) / 6. Levels are mixed to match the disc. For an ellipse the levels follow its
// short axis, and nine taps along the long one make up the difference.
//
// Inputs
//   color_tx       rgba of the picture, which is level 0
//   pyramid_tx     rgba of the levels above it, at `level_rects`
//   coc_tx         r signed coc (circle of confusion, diameter in pixels, negative in front of the focus)
// Output
//   out_color_img  rgba, blurred

#include "lib/aperture.lib.glsl"  // aperture_variances

layout(local_size_x = PIXEL_GROUP, local_size_y = PIXEL_GROUP) in;

#define TAPS 4               // taps on each side of the middle one
#define TAP_SPREAD 2.0       // standard deviation of the taps, in taps
#define TAPS_VARIANCE 3.4283 // variance of nine taps with these weights, in taps^2

uniform sampler2D color_tx;
uniform sampler2D pyramid_tx;
uniform sampler2D coc_tx;
uniform ivec4 level_rects[PYRAMID_LEVELS_MAX];  // corner and size of level 1, level 2, ..
uniform int levels;                             // number of levels, without level 0
layout(rgba32f) uniform writeonly image2D out_color_img;

// Variance in px^2 of the blur of a level.
float level_variance(int level) { return (exp2(2.0 * float(level)) - 1.0) / 2.0; }

// A texel of a level, clamped to its edge.
vec4 texel(int level, ivec2 at) {
    if (level == 0) return texelFetch(color_tx, clamp(at, ivec2(0), textureSize(color_tx, 0) - 1), 0);
    ivec4 rect = level_rects[level - 1];
    return texelFetch(pyramid_tx, rect.xy + clamp(at, ivec2(0), rect.zw - 1), 0);
}

// A level at a pixel of the picture, interpolated linearly.
vec4 level_at(int level, vec2 at) {
    vec2 level_position = at / exp2(float(level)), fraction = fract(level_position);
    ivec2 low = ivec2(floor(level_position));
    vec4 above = mix(texel(level, low), texel(level, low + ivec2(1, 0)), fraction.x);
    vec4 below = mix(texel(level, low + ivec2(0, 1)), texel(level, low + 1), fraction.x);
    return mix(above, below, fraction.y);
}

// The picture with a blur of this variance, mixed from two levels.
vec4 blurred_at(vec2 at, float variance) {
    int level = clamp(int(floor(0.5 * log2(2.0 * variance + 1.0))), 0, levels);
    vec4 low = level_at(level, at);
    if (level == levels) return low;
    float from = level_variance(level), to = level_variance(level + 1);
    float fraction = clamp((variance - from) / (to - from), 0.0, 1.0);
    return fraction == 0.0 ? low : mix(low, level_at(level + 1, at), fraction);
}

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(at, textureSize(color_tx, 0)))) return;
    float coc = min(abs(texelFetch(coc_tx, at, 0).r), 1e9);
    vec2 variances = aperture_variances(0.5 * coc);
    // extra_variance: by how much the long axis is blurred more than the short one.
    float least = min(variances.x, variances.y), extra_variance = max(variances.x, variances.y) - least;
    vec4 color = vec4(0.0);
    if (extra_variance <= 1e-6 * least) {
        color = blurred_at(vec2(at), least);
    } else {
        vec2 tap = (variances.x > variances.y ? vec2(1, 0) : vec2(0, 1)) * sqrt(extra_variance / TAPS_VARIANCE);
        float weight = 0.0;
        for (int k = -TAPS; k <= TAPS; ++k) {
            float w = exp(-0.5 * float(k * k) / (TAP_SPREAD * TAP_SPREAD));
            vec2 tap_at = vec2(at) + float(k) * tap;
            if (any(lessThan(tap_at, vec2(0.0))) || any(greaterThan(tap_at, vec2(textureSize(color_tx, 0) - 1))))
                continue;
            color += w * blurred_at(tap_at, least);
            weight += w;
        }
        color /= weight;
    }
    imageStore(out_color_img, at, color);
}

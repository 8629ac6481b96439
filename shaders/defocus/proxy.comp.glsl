// Reduces the picture to a smaller working size. Color is averaged over each pixel's footprint, which is the area of
// the whole picture that it covers. Depth is the sample at the middle of the footprint, because a mean of two depths
// would be a surface that does not exist. If the footprint holds a highlight, depth is the highlight's: its light
// dominates the pixel, and would otherwise become a disc of the wrong size.
//
// Inputs
//   color_tx         rgba at full size
//   depth_tx         r depth in meters, or signed coc in pixels (circle of confusion), at full size
// Outputs
//   out_color_img      rgba at the smaller size
//   out_depth_img      r depth at the smaller size; a coc is in its pixels
//   out_positions_img  with POSITIONS, of highlights only, else 0: rg position of the light from the pixel's middle, b
//                      its variance along an axis, in pixels of the smaller size (highlight_sprites.comp.glsl)

#include "lib/footprint.lib.glsl"  // Footprint, footprint_of, center_of, share_in
#include "lib/highlight_limit.lib.glsl"  // LEAST_LUMINANCE, limit_of, mean_of

layout(local_size_x = PIXEL_GROUP, local_size_y = PIXEL_GROUP) in;

uniform sampler2D color_tx;
uniform sampler2D depth_tx;
uniform float depth_scale;  // 1 for meters, the proxy's scale where depth_tx holds pixels of coc
layout(rgba32f) uniform writeonly image2D out_color_img;
layout(r32f) uniform writeonly image2D out_depth_img;
#ifdef POSITIONS
layout(rgba16f) uniform writeonly image2D out_positions_img;

// Position of the light in a footprint (rg, in pixels of the smaller picture from the middle) and its variance (b).
// Weights are the square of the light, so that the darker surroundings hardly count.
vec4 light_position(Footprint footprint) {
    vec2 extent = footprint.high - footprint.low, moment = vec2(0.0);
    float sum = 0.0, moment_2 = 0.0;
    for (int y = footprint.first.y; y <= footprint.last.y; ++y)
        for (int x = footprint.first.x; x <= footprint.last.x; ++x) {
            float light = mean_of(texelFetch(color_tx, ivec2(x, y), 0).rgb);
            float weight = share_in(footprint, ivec2(x, y)) * light * light;
            vec2 source = (vec2(x, y) + 0.5 - footprint.low) / extent - 0.5;
            sum += weight;
            moment += weight * source;
            moment_2 += weight * dot(source, source);
        }
    vec2 middle = moment / sum;
    return vec4(middle, max(0.5 * (moment_2 / sum - dot(middle, middle)), 0.0), 0.0);
}
#endif

#define AROUND_TAPS 3  // samples of the surroundings of a highlight, to each side
#define AROUND_STEP 2  // spacing of the samples in pixels of the smaller picture

// Mean rgba of a footprint; `brightest` becomes its brightest pixel.
vec4 footprint_mean(Footprint footprint, out ivec2 brightest) {
    vec4 sum = vec4(0.0);
    float most = -1.0;
    for (int y = footprint.first.y; y <= footprint.last.y; ++y) {
        // Overlaps of this row and column with the footprint, whose product is the weight of the pixel.
        float overlap_y = min(footprint.high.y, float(y + 1)) - max(footprint.low.y, float(y));
        for (int x = footprint.first.x; x <= footprint.last.x; ++x) {
            float overlap_x = min(footprint.high.x, float(x + 1)) - max(footprint.low.x, float(x));
            vec4 color = texelFetch(color_tx, ivec2(x, y), 0);
            sum += overlap_x * overlap_y * color;
            float light = overlap_x * overlap_y * mean_of(color.rgb);
            if (light > most) brightest = ivec2(x, y);
            most = max(most, light);
        }
    }
    vec2 extent = footprint.high - footprint.low;
    return sum / (extent.x * extent.y);
}

// Mean luminance around a pixel of the smaller picture, clipped to 1 so that highlights do not raise it.
float luminance_around(ivec2 at, ivec2 size) {
    ivec2 whole_size = textureSize(color_tx, 0);
    float sum = 0.0;
    for (int y = -AROUND_TAPS; y <= AROUND_TAPS; ++y)
        for (int x = -AROUND_TAPS; x <= AROUND_TAPS; ++x) {
            ivec2 tap = clamp(at + AROUND_STEP * ivec2(x, y), ivec2(0), size - 1);
            vec3 color = texelFetch(color_tx, center_of(tap, size, whole_size), 0).rgb;
            sum += clamp(mean_of(color), 0.0, 1.0);
        }
    return sum / float((2 * AROUND_TAPS + 1) * (2 * AROUND_TAPS + 1));
}

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy), size = imageSize(out_color_img);
    if (any(greaterThanEqual(at, size))) return;
    ivec2 whole_size = textureSize(color_tx, 0), source = center_of(at, size, whole_size), brightest = source;
    vec4 mean = footprint_mean(footprint_of(at, size, whole_size), brightest);
    imageStore(out_color_img, at, mean);
    float light = mean_of(texelFetch(color_tx, brightest, 0).rgb);
    float around = light > LEAST_LUMINANCE ? luminance_around(at, size) : 0.0;
    bool is_highlight = light > limit_of(around) && mean_of(mean.rgb) > limit_of(around);
    if (is_highlight) source = brightest;
#ifdef POSITIONS
    vec4 position = vec4(0.0);
    // A loop in place of an if: a software rasterizer runs both sides of every branch (shaders/README.md).
    for (int n = is_highlight ? 1 : 0; n > 0; --n) position = light_position(footprint_of(at, size, whole_size));
    imageStore(out_positions_img, at, position);
#endif
    imageStore(out_depth_img, at, vec4(texelFetch(depth_tx, source, 0).r * depth_scale));
}

// Reduces the plate to the size of a preview. Each pixel is the mean of those pixels of the plate under it that are in
// focus. The plain mean would include the color of blurred objects at their silhouettes, which the preview spreads.
//
// Inputs
//   color_tx   the plate, scene-linear rgb, premultiplied, and alpha
//   depth_tx   r depth of the plate in meters, or its signed coc (circle of confusion) in pixels if is_coc
//   mean_tx    the plain mean of the plate, at the size of the preview
//   diffused_tx  rgb the same times diffused_scale, without the highlights that the preview draws as discs
//   range_tx   rg the least and the greatest depth under each pixel of the preview (depth_range.comp.glsl)
// Output
//   out_img    rgb mean of the pixels in focus, the plain mean where all or none are in focus, both without these
//              highlights; a the greatest share of the detail at a pixel

#include "lib/footprint.lib.glsl"  // Footprint, footprint_of, center_of, share_in
#include "lib/focus_share.lib.glsl"  // signed_px, focus_share, share_of

layout(local_size_x = PIXEL_GROUP, local_size_y = PIXEL_GROUP) in;

uniform sampler2D color_tx;
uniform sampler2D depth_tx;
uniform sampler2D mean_tx;
uniform sampler2D diffused_tx;
uniform float diffused_scale;
uniform sampler2D range_tx;
layout(rgba32f) uniform writeonly image2D out_img;

// The next pixel of a footprint, row by row. Without a GPU one flat loop is cheaper than a loop inside a loop.
ivec2 after(ivec2 pixel, Footprint footprint) {
    bool is_last = pixel.x == footprint.last.x;
    return is_last ? ivec2(footprint.first.x, pixel.y + 1) : pixel + ivec2(1, 0);
}

// The sum of the pixels of a footprint, weighted by how far they are in focus, and their weight. Unless `is_needed` the
// loop ends after the first pixel, which saves time, and the result is not used.
vec4 sum_in_focus(Footprint footprint, bool is_needed) {
    vec4 sum = vec4(0.0);
    ivec2 pixel = footprint.first;
    do {
        float pixel_weight = share_in(footprint, pixel) * focus_share(texelFetch(depth_tx, pixel, 0).r, pixel);
        sum += pixel_weight * vec4(texelFetch(color_tx, pixel, 0).rgb, 1.0);
        pixel = after(pixel, footprint);
    } while (is_needed && pixel.y <= footprint.last.y);
    return sum;
}

// Share of the plate's light that the preview diffuses at a pixel. Drawn as a disc, a lamp has no pixel of the preview's
// size: were it taken from the preview with the rest of the coarse plate, its pixel would stand as a square around it.
vec3 diffused_share(ivec2 at) {
    vec3 mean = texelFetch(mean_tx, at, 0).rgb, diffused = texelFetch(diffused_tx, at, 0).rgb / diffused_scale;
    return mix(vec3(1.0), clamp(diffused / max(mean, vec3(1e-20)), 0.0, 1.0), greaterThan(mean, vec3(0.0)));
}

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy), size = imageSize(out_img);
    if (any(greaterThanEqual(at, size))) return;
    ivec2 whole_size = textureSize(depth_tx, 0), center = center_of(at, size, whole_size);
    vec2 range = texelFetch(range_tx, at, 0).rg;
    float one_px = signed_px(range.r, center), other_px = signed_px(range.g, center);
    bool is_focus_between = one_px * other_px <= 0.0;
    float least_px = is_focus_between ? 0.0 : min(abs(one_px), abs(other_px));
    float most_share = share_of(least_px), least_share = share_of(max(abs(one_px), abs(other_px)));
    bool is_mixed = least_share < 1.0 && most_share > 0.0;
    vec4 sum = sum_in_focus(footprint_of(at, size, whole_size), is_mixed);
    // The focus may lie between the depths without a pixel there.
    bool has_sum = is_mixed && sum.a > 0.0;
    vec3 mean = has_sum ? sum.rgb / sum.a : texelFetch(mean_tx, at, 0).rgb;
    imageStore(out_img, at, vec4(mean * diffused_share(at), is_mixed && !has_sum ? 0.0 : most_share));
}

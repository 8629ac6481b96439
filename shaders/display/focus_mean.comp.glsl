// Reduces the plate to the size of a preview. Each pixel is the mean of those pixels of the plate under it that are in
// focus. The plain mean would include the color of blurred objects at their silhouettes, which the preview spreads.
//
// Inputs
//   color_tx   the plate, scene-linear rgb, premultiplied, and alpha
//   depth_tx   r depth of the plate in meters, or its signed coc (circle of confusion) in pixels if is_coc
//   mean_tx    the plain mean of the plate, at the size of the preview
// Output
//   out_img    rgba mean of the pixels in focus; the plain mean where all or none are in focus

#include "lib/footprint.lib.glsl"  // Footprint, footprint_of, share_in
#include "lib/focus_share.lib.glsl"  // width_px, share_of

layout(local_size_x = PIXEL_GROUP, local_size_y = PIXEL_GROUP) in;

uniform sampler2D color_tx;
uniform sampler2D depth_tx;
uniform sampler2D mean_tx;
layout(rgba32f) uniform writeonly image2D out_img;

// Diameter of the circle of confusion at a pixel of the plate, in pixels.
float width_at(ivec2 pixel) { return width_px(texelFetch(depth_tx, pixel, 0).r, pixel); }

// The next pixel of a footprint, row by row. Without a GPU one flat loop is cheaper than a loop inside a loop.
ivec2 after(ivec2 pixel, Footprint footprint) {
    bool is_last = pixel.x == footprint.last.x;
    return is_last ? ivec2(footprint.first.x, pixel.y + 1) : pixel + ivec2(1, 0);
}

// The mean of the pixels of a footprint, weighted by how far they are in focus. Unless `is_needed` the loop ends after
// the first pixel, which saves time, and the result is not used.
vec4 mean_in_focus(Footprint footprint, bool is_needed) {
    vec4 sum = vec4(0.0);
    float weight = 0.0;
    ivec2 pixel = footprint.first;
    do {
        float pixel_weight = share_in(footprint, pixel) * share_of(width_at(pixel));
        sum += pixel_weight * texelFetch(color_tx, pixel, 0);
        weight += pixel_weight;
        pixel = after(pixel, footprint);
    } while (is_needed && pixel.y <= footprint.last.y);
    return sum / weight;
}

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy), size = imageSize(out_img);
    if (any(greaterThanEqual(at, size))) return;
    Footprint footprint = footprint_of(at, size, textureSize(depth_tx, 0));
    float least_px = 1e30, most_px = 0.0;
    ivec2 pixel = footprint.first;
    do {
        float px = width_at(pixel);
        least_px = min(least_px, px);
        most_px = max(most_px, px);
        pixel = after(pixel, footprint);
    } while (pixel.y <= footprint.last.y);
    bool is_mixed = share_of(most_px) < 1.0 && share_of(least_px) > 0.0;
    vec4 in_focus = mean_in_focus(footprint, is_mixed);
    imageStore(out_img, at, is_mixed ? in_focus : texelFetch(mean_tx, at, 0));
}

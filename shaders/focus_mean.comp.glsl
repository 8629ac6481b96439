// Reduces the plate to the size of a preview: each pixel is the mean of the plate's pixels in focus under it.
// At the silhouette of a blurred object the plain mean would hold its colour, which the preview spreads.
//
// Inputs
//   color_tx   the plate, scene-linear, premultiplied
//   depth_tx   of the plate, see lib/focus_share.lib.glsl
//   mean_tx    the plain mean of the plate, at the preview's size
// Output
//   out_img    the mean of the pixels in focus; the plain mean where all or none are in focus

#include "lib/footprint.lib.glsl"
#include "lib/focus_share.lib.glsl"

layout(local_size_x = PIXEL_GROUP, local_size_y = PIXEL_GROUP) in;

uniform sampler2D color_tx;
uniform sampler2D depth_tx;
uniform sampler2D mean_tx;
layout(rgba32f) uniform writeonly image2D out_img;

float share_at(ivec2 pixel) { return focus_share(texelFetch(depth_tx, pixel, 0).r, pixel); }

vec4 mean_in_focus(Footprint footprint) {
    vec4 sum = vec4(0.0);
    float weight = 0.0;
    for (int y = footprint.first.y; y <= footprint.last.y; ++y)
        for (int x = footprint.first.x; x <= footprint.last.x; ++x) {
            float part = part_in(footprint, ivec2(x, y)) * share_at(ivec2(x, y));
            sum += part * texelFetch(color_tx, ivec2(x, y), 0);
            weight += part;
        }
    return sum / weight;
}

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy), size = imageSize(out_img);
    if (any(greaterThanEqual(at, size))) return;
    Footprint footprint = footprint_of(at, size, textureSize(depth_tx, 0));
    float least = 1.0, most = 0.0;
    for (int y = footprint.first.y; y <= footprint.last.y; ++y)
        for (int x = footprint.first.x; x <= footprint.last.x; ++x) {
            float share = share_at(ivec2(x, y));
            least = min(least, share);
            most = max(most, share);
        }
    bool is_mixed = least < 1.0 && most > 0.0;
    imageStore(out_img, at, is_mixed ? mean_in_focus(footprint) : texelFetch(mean_tx, at, 0));
}

// Finds the least and the greatest depth under each pixel of a preview.
//
// Input
//   depth_tx   r depth of the plate in meters, or its signed coc (circle of confusion) in pixels
// Output
//   out_img    r the least, g the greatest, at the size of the preview

#include "lib/footprint.lib.glsl"  // Footprint, footprint_of

layout(local_size_x = PIXEL_GROUP, local_size_y = PIXEL_GROUP) in;

uniform sampler2D depth_tx;
layout(rgba32f) uniform writeonly image2D out_img;

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy), size = imageSize(out_img);
    if (any(greaterThanEqual(at, size))) return;
    Footprint footprint = footprint_of(at, size, textureSize(depth_tx, 0));
    float least = texelFetch(depth_tx, footprint.first, 0).r, greatest = least;
    for (int y = footprint.first.y; y <= footprint.last.y; ++y)
        for (int x = footprint.first.x; x <= footprint.last.x; ++x) {
            float depth = texelFetch(depth_tx, ivec2(x, y), 0).r;
            least = min(least, depth);
            greatest = max(greatest, depth);
        }
    imageStore(out_img, at, vec4(least, greatest, 0.0, 0.0));
}

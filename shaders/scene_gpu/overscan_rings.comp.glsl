// Finds the nearest and the farthest depth in each ring of pixels around a picture. The rings make up the overscan: the
// margin of pixels outside the picture. From the depths the CPU computes how much of the overscan blurs into the
// picture through any lens. Depths are compared by their bits, because the bits of positive floats sort as the floats
// do.
//
// Inputs
//   depth_tx    planar depth of picture and overscan, meters, +inf where nothing was hit
//   margin_px   width of the overscan on every side
// Output
//   ring_buf    bits of the nearest and of the farthest depth of each ring, from the innermost one on; has to contain
//               ~0, 0 for each before the pass

layout(local_size_x = PIXEL_GROUP, local_size_y = PIXEL_GROUP) in;

uniform sampler2D depth_tx;
uniform int margin_px;
layout(std430) buffer ring_block { uint ring_buf[]; };

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy), size = textureSize(depth_tx, 0);
    if (any(greaterThanEqual(at, size))) return;
    ivec2 inside = min(at, size - 1 - at);
    int ring = margin_px - min(inside.x, inside.y);
    if (ring <= 0) return;
    uint depth = floatBitsToUint(texelFetch(depth_tx, at, 0).r);
    atomicMin(ring_buf[2 * ring - 2], depth);
    atomicMax(ring_buf[2 * ring - 1], depth);
}

// Finds the nearest and the farthest depth of a picture, and counts the pixels that hit nothing. Depths are compared by
// their bits as whole numbers, because the bits of positive floats sort as the floats do, +inf last.
//
// Input
//   depth_img    planar depth, meters, +inf where nothing was hit
// Output
//   bounds       bits of depths, and a count; has to contain ~0, 0, 0, 0 before the pass

#define WORKERS 256
layout(local_size_x = WORKERS) in;

layout(r32f) uniform readonly image2D depth_img;
layout(std430) buffer bounds_block {
    uint nearest;
    uint farthest;
    uint farthest_hit;  // the farthest depth that is not +inf; 0 if nothing was hit
    uint infinite;      // number of pixels that hit nothing
} bounds;

const uint INFINITE = 0x7f800000u;  // the bits of +inf

shared uint nearest_sh, farthest_sh, farthest_hit_sh, infinite_sh;

void main() {
    if (gl_LocalInvocationIndex == 0u) {
        nearest_sh = ~0u;
        farthest_sh = farthest_hit_sh = infinite_sh = 0u;
    }
    barrier();
    ivec2 size = imageSize(depth_img);
    uint nearest = ~0u, farthest = 0u, farthest_hit = 0u, infinite = 0u;
    for (int y = int(gl_WorkGroupID.x); y < size.y; y += int(gl_NumWorkGroups.x))
        for (int x = int(gl_LocalInvocationID.x); x < size.x; x += WORKERS) {
            uint depth = floatBitsToUint(imageLoad(depth_img, ivec2(x, y)).r);
            nearest = min(nearest, depth);
            farthest = max(farthest, depth);
            farthest_hit = max(farthest_hit, depth < INFINITE ? depth : 0u);
            infinite += depth < INFINITE ? 0u : 1u;
        }
    atomicMin(nearest_sh, nearest);
    atomicMax(farthest_sh, farthest);
    atomicMax(farthest_hit_sh, farthest_hit);
    atomicAdd(infinite_sh, infinite);
    barrier();
    if (gl_LocalInvocationIndex == 0u) {
        atomicMin(bounds.nearest, nearest_sh);
        atomicMax(bounds.farthest, farthest_sh);
        atomicMax(bounds.farthest_hit, farthest_hit_sh);
        atomicAdd(bounds.infinite, infinite_sh);
    }
}

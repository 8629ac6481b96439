// Counts the pixels in each of DEPTH_BINS even bins of dioptres (1 / meters), exactly as core/model/value_bins.py does.
// The empty bins determine the layers, so the result must not depend on the machine. Each workgroup counts in shared
// memory first.
//
// Input
//   depth_img    planar depth, meters up to 1e37, +inf where nothing was hit
// Output
//   count_buf    number of pixels in each bin; has to contain zeros before the pass

#include "lib/reciprocal.lib.glsl"  // reciprocal

#define WORKERS 256
layout(local_size_x = WORKERS) in;

layout(r32f) uniform readonly image2D depth_img;
uniform float low_dioptres;  // at which the first bin begins
uniform float bins_per_dioptre;
layout(std430) buffer count_block { uint count_buf[DEPTH_BINS]; };

shared uint counts_sh[DEPTH_BINS];

void main() {
    int worker = int(gl_LocalInvocationID.x);
    for (int i = worker; i < DEPTH_BINS; i += WORKERS) counts_sh[i] = 0u;
    barrier();
    ivec2 size = imageSize(depth_img);
    for (int y = int(gl_WorkGroupID.x); y < size.y; y += int(gl_NumWorkGroups.x))
        for (int x = worker; x < size.x; x += WORKERS) {
            precise float above = reciprocal(imageLoad(depth_img, ivec2(x, y)).r) - low_dioptres;
            precise float bin = above * bins_per_dioptre;
            atomicAdd(counts_sh[clamp(int(bin), 0, DEPTH_BINS - 1)], 1u);
        }
    barrier();
    for (int i = worker; i < DEPTH_BINS; i += WORKERS)
        if (counts_sh[i] > 0u) atomicAdd(count_buf[i], counts_sh[i]);
}

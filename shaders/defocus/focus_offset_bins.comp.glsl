// Makes a histogram of the depths in a picture: counts the surfaces in each of DEPTH_BINS equal bins of effective
// dioptres. These are the dioptres (1 / meters) of a surface plus the focus offset at its pixel: with them, a lens
// with a tilted focus plane blurs like one without a tilt.
//
// Inputs
//   depth_tx    r planar meters
//   with LISTS, lib/fragment_list.lib.glsl, where a fragment_line of (0, 1) makes the coc of a fragment its dioptres
// Output
//   count_buf   surfaces in each bin; zeros before the pass

#include "lib/focus_offset.lib.glsl"  // focus_offset_at
#ifdef LISTS
#include "lib/fragment_list.lib.glsl"  // List, list_at, fragment_of
#endif

layout(local_size_x = PIXEL_GROUP, local_size_y = PIXEL_GROUP) in;

uniform sampler2D depth_tx;
uniform float low_dioptres;  // at which the first bin begins
uniform float bins_per_dioptre;
layout(std430) buffer count_block { uint count_buf[DEPTH_BINS]; };

// Counts one surface; dioptres outside all bins go into the first or the last.
void count(float dioptres) {
    atomicAdd(count_buf[clamp(int((dioptres - low_dioptres) * bins_per_dioptre), 0, DEPTH_BINS - 1)], 1u);
}

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(at, textureSize(depth_tx, 0)))) return;
    count(1.0 / texelFetch(depth_tx, at, 0).r + focus_offset_at(at));
#ifdef LISTS
    List list = list_at(at);
    for (uint i = list.first; i < list.end; ++i) count(fragment_of(i).coc);
#endif
}

// Counts the fragments in each of DEPTH_BINS even bins of dioptres, see depth_bins.comp.glsl.
//
// Input
//   fragment_buf   three words a fragment, the third its dioptres
// Output
//   count_buf      added to

layout(local_size_x = WORD_GROUP) in;

layout(std430) readonly buffer fragment_block { uint fragment_buf[]; };
layout(std430) buffer count_block { uint count_buf[DEPTH_BINS]; };
uniform int fragment_count;
uniform float low;
uniform float per_step;

void main() {
    uint stride = gl_NumWorkGroups.x * WORD_GROUP;
    for (uint i = gl_GlobalInvocationID.x; i < uint(fragment_count); i += stride) {
        float above = uintBitsToFloat(fragment_buf[3u * i + 2u]) - low;
        atomicAdd(count_buf[clamp(int(above * per_step), 0, DEPTH_BINS - 1)], 1u);
    }
}

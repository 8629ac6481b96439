// Counts the listed fragments in each of DEPTH_BINS even bins of dioptres, as depth_bins.comp.glsl does with pixels.
//
// Inputs
//   fragment_buf   three words a fragment, the third its dioptres (lib/fragment_words.lib.glsl)
//   low_dioptres   at which the first bin begins
// Output
//   count_buf      number in each bin; the fragments are added to what it contains

layout(local_size_x = WORD_GROUP) in;

layout(std430) readonly buffer fragment_block { uint fragment_buf[]; };
layout(std430) buffer count_block { uint count_buf[DEPTH_BINS]; };
uniform int fragment_count;
uniform float low_dioptres;
uniform float bins_per_dioptre;

void main() {
    uint stride = gl_NumWorkGroups.x * WORD_GROUP;
    for (uint i = gl_GlobalInvocationID.x; i < uint(fragment_count); i += stride) {
        float above = uintBitsToFloat(fragment_buf[3u * i + 2u]) - low_dioptres;
        atomicAdd(count_buf[clamp(int(above * bins_per_dioptre), 0, DEPTH_BINS - 1)], 1u);
    }
}

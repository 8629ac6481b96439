// Decides which samples of a pixel a partly transparent surface covers.
//
// A surface has a threshold between 0 and 1 in each sample, and covers the sample if its alpha is higher. The
// thresholds of one surface are evenly spread over the samples of a pixel, and those of different surfaces are
// independent. They are numbers of the van der Corput sequence, shuffled and scrambled as in Burley 2020 ("Practical
// hash-based Owen scrambling"). Include lib/random.lib.glsl first.

#include "lib/samples.lib.glsl"  // sample_position, pixel_of, number_of, samples_across

#define HALF 0.49999  // with a single sample, as for a depth, a surface covers it if its alpha is one half or more

// Number of this draw, each of which has samples_across^2 samples of a pixel; -1: all thresholds are HALF.
uniform int draw_number;

// Scrambles a number so that each bit of the result depends only on this bit and the lower ones.
uint scramble(uint x, uint seed) {
    x += seed;
    x ^= x * 0x6c50b47cu;
    x ^= x * 0xb82f1e52u;
    x ^= x * 0xc7afe638u;
    x ^= x * 0x8d22f6e6u;
    return x;
}

// Threshold of a surface, given by its material and triangle, in the sample of this fragment.
float threshold_of(uint material, uint triangle) {
    if (draw_number < 0) return HALF;
    ivec2 position = sample_position();
    uint number = uint(draw_number * samples_across * samples_across + number_of(position));
    uvec4 seeds = hash_counters(uvec4(pixel_of(position), material, triangle));
    // The order of the samples is shuffled too; otherwise two surfaces would cover the same ones.
    uint shuffled_number = bitfieldReverse(scramble(bitfieldReverse(number), seeds.x));
    // A number with its bits reversed, as a binary fraction, is its term of the van der Corput sequence.
    return float(bitfieldReverse(scramble(shuffled_number, seeds.y)) >> 8u) * (1.0 / 16777216.0);
}

// What is a highlight: light that exceeds its surroundings (highlight_luminance.comp.glsl) by much.

#include "lib/tone.lib.glsl"

#define TIMES_BRIGHTER 3.0
#define LEAST_LUMINANCE 0.25  // grain in the dark is not a highlight

float limit_of(float around) { return TIMES_BRIGHTER * around + LEAST_LUMINANCE; }

// How much of this light is a highlight's, 0..1. Of what is far beyond the limit no more is left than
// its surroundings have.
float part_over(vec3 color, float around) {
    float luminance = mean_of(color), limit = limit_of(around);
    float rest = around + (limit - around) * limit / max(luminance, limit);
    return luminance > limit ? 1.0 - rest / luminance : 0.0;
}

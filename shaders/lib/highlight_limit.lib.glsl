// What is a highlight: light that exceeds its surroundings (highlight_luminance.comp.glsl) by much.

#include "lib/tone.lib.glsl"

#define TIMES_BRIGHTER 3.0
#define LEAST_LUMINANCE 0.25  // grain in the dark is not a highlight

// A surface is bright if its luminance is above 1, where that of surroundings is clipped. What is many times
// brighter still is a lamp, however large: the ripple of its diffusion would be seen on the wall around it.
#define LAMP_FROM 10.0  // up to this luminance a surface is diffused,
#define LAMP_TO 40.0    // and from this one on it is drawn as discs
#define SURFACE_FROM 0.3  // where this part of the surroundings is bright a highlight may be a surface,
#define SURFACE_TO 0.6    // and from this part on it is one
#define NO_HIGHLIGHT 60000.0  // surroundings that nothing outshines; half floats hold it

float limit_of(float around) { return TIMES_BRIGHTER * around + LEAST_LUMINANCE; }

// How much light of this luminance counts as that of a bright surface, 0..1.
float surface_part(float luminance) {
    return luminance > 1.0 ? 1.0 - smoothstep(LAMP_FROM, LAMP_TO, luminance) : 0.0;
}

// How much this is a bright surface, 0..1, of the part of the surroundings that is bright.
float surface_of(float bright_part) { return smoothstep(SURFACE_FROM, SURFACE_TO, bright_part); }

// How much of this light is a highlight's, 0..1. Of what is far beyond the limit no more is left than
// its surroundings have.
float part_over(vec3 color, float around) {
    float luminance = mean_of(color), limit = limit_of(around);
    float rest = around + (limit - around) * limit / max(luminance, limit);
    return luminance > limit ? 1.0 - rest / luminance : 0.0;
}

// Defines highlights: light much brighter than its surroundings (highlight_luminance.comp.glsl).

#include "lib/tone.lib.glsl"

#define TIMES_BRIGHTER 3.0    // ratio to the surroundings from which light is a highlight
#define LEAST_LUMINANCE 0.25  // added to the limit, because grain in the dark is not a highlight

// A surface is bright if its luminance is above 1, the value at which surroundings are clipped. Light that
// is many times brighter is a lamp, however large: its ripple would show on the wall around it.
#define LAMP_FROM 10.0  // luminance up to which a surface is diffused
#define LAMP_TO 40.0    // luminance from which it is drawn as discs
#define SURFACE_FROM 0.3  // share of bright surroundings from which a highlight may be a surface
#define SURFACE_TO 0.6    // share from which it is a surface
#define NO_HIGHLIGHT 60000.0  // brighter than any picture, but within the range of half floats

float limit_of(float around) { return TIMES_BRIGHTER * around + LEAST_LUMINANCE; }

// Degree to which light of this luminance belongs to a bright surface, 0..1.
float surface_share(float luminance) {
    return luminance > 1.0 ? 1.0 - smoothstep(LAMP_FROM, LAMP_TO, luminance) : 0.0;
}

// Degree to which this is a bright surface, 0..1, from the bright share of its surroundings.
float surface_of(float bright_part) { return smoothstep(SURFACE_FROM, SURFACE_TO, bright_part); }

// Share of this light that belongs to a highlight, 0..1. Of light far above the limit, all but the level of the
// surroundings belongs to it.
float highlight_share(vec3 color, float around) {
    float luminance = mean_of(color), limit = limit_of(around);
    float remaining = around + (limit - around) * limit / max(luminance, limit);
    return luminance > limit ? 1.0 - remaining / luminance : 0.0;
}

// Defines highlights: light much brighter than its surroundings, which is drawn as discs instead of being diffused.
//
//   luminance   mean of red, green and blue
//   around      luminance of the surroundings, clipped to 0..1 (highlight_luminance.comp.glsl)
//   limit       luminance above which light is a highlight

#include "lib/tone.lib.glsl"  // mean_of

#define TIMES_BRIGHTER 3.0    // ratio to the surroundings from which light is a highlight
#define LEAST_LUMINANCE 0.25  // added to the limit, because grain in the dark is not a highlight

// A surface is bright if its luminance is above 1, the value at which surroundings are clipped. Light that
// is many times brighter is a lamp, however large: diffused, its ripple would show on the wall around it.
#define LAMP_FROM 10.0  // luminance up to which a surface is diffused
#define LAMP_TO 40.0    // luminance from which it is drawn as discs
#define SURFACE_FROM 0.3  // share of bright surroundings from which a highlight may be a surface
#define SURFACE_TO 0.6    // share from which it is a surface
#define NO_HIGHLIGHT 60000.0  // brighter than any picture, but within the range of half floats

// The limit for these surroundings.
float limit_of(float around) { return TIMES_BRIGHTER * around + LEAST_LUMINANCE; }

// Degree to which light of this luminance belongs to a bright surface, 0..1.
float surface_share(float luminance) {
    return luminance > 1.0 ? 1.0 - smoothstep(LAMP_FROM, LAMP_TO, luminance) : 0.0;
}

// Degree to which this is a bright surface, 0..1. `bright_share` is the share of its surroundings that is bright.
float surface_of(float bright_share) { return smoothstep(SURFACE_FROM, SURFACE_TO, bright_share); }

// Degree to which a surface with this signed coc is not before the focus, 0..1. Between dark things before the focus, a
// bright surface is measured among such surfaces alone: a sky between leaves is no lamp, however little of it is seen.
float not_before_focus(float coc) { return smoothstep(-1.5, -0.5, coc); }

// Share of this light that belongs to a highlight, 0..1. What remains is the limit for light just above the limit, and
// falls to the level of the surroundings for light far above it.
float highlight_share(vec3 color, float around) {
    float luminance = mean_of(color), limit = limit_of(around);
    float remaining = around + (limit - around) * limit / max(luminance, limit);
    return luminance > limit ? 1.0 - remaining / luminance : 0.0;
}

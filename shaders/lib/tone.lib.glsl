// Compresses bright colours while they are averaged or compared, so that a highlight at the rim does
// not spread into the area filled in behind it. Invertible; hue is preserved.

#define TONE_MEAN_MAX 0.98  // a compressed mean of 1 would map back to infinity

float mean_of(vec3 c) { return (c.r + c.g + c.b) / 3.0; }
vec3 compress_light(vec3 c) { return c / (1.0 + max(mean_of(c), 0.0)); }
vec3 expand_light(vec3 c) { return c / (1.0 - min(mean_of(c), TONE_MEAN_MAX)); }

// The same for highlights alone: other colours hardly change, so that their mean conserves light.

#define DIMMED_MOST 2.0         // the limit that bright light approaches
#define DIMMED_MEAN_MAX 0.9999  // share of the limit: a mean of 1 would map back to infinity

vec3 dim(vec3 c) {
    float relative_light = max(mean_of(c), 0.0) / DIMMED_MOST;
    return c * inversesqrt(1.0 + relative_light * relative_light);
}

vec3 undim(vec3 c) {
    float relative_light = min(mean_of(c) / DIMMED_MOST, DIMMED_MEAN_MAX);
    return c * inversesqrt(1.0 - relative_light * relative_light);
}

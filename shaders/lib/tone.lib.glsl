// Compresses the range of bright colors while they are averaged or compared, and expands it again. Without
// this a highlight at a rim would spread into the area that is filled in behind it. Hue is preserved.

#define TONE_MEAN_MAX 0.98  // a compressed mean of 1 would map back to infinity

float mean_of(vec3 c) { return (c.r + c.g + c.b) / 3.0; }
vec3 compress_light(vec3 c) { return c / (1.0 + max(mean_of(c), 0.0)); }
vec3 expand_light(vec3 c) { return c / (1.0 - min(mean_of(c), TONE_MEAN_MAX)); }

// The same for highlights alone: `dim` compresses and `undim` expands. Other colors hardly change, so that their mean
// conserves light.

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

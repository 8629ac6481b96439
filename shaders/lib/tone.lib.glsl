// Bright colours compressed while they are averaged or compared, so that one lamp at the rim does
// not paint what is filled in behind it. Invertible; hue is kept.

#define TONE_MEAN_MAX 0.98  // a compressed mean of 1 would map back to infinity

float mean_of(vec3 c) { return (c.r + c.g + c.b) / 3.0; }
vec3 toned(vec3 c) { return c / (1.0 + max(mean_of(c), 0.0)); }
vec3 untoned(vec3 c) { return c / (1.0 - min(mean_of(c), TONE_MEAN_MAX)); }

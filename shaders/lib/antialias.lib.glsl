// Luminance of scene-linear rgb, for comparing the samples of a pixel. The three primaries have different weights, so
// that an edge between colors is detected as well as one between light and dark.
float luminance(vec3 light) { return dot(light, vec3(0.27, 0.56, 0.17)); }

// What samples of a pixel are compared by. No two primaries of equal weight: an edge between colours
// is seen as well as one between light and dark.
float luminance(vec3 light) { return dot(light, vec3(0.27, 0.56, 0.17)); }

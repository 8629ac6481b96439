// What a surface's colour is multiplied by, and in alpha its opacity: the colours of its vertices
// with COLORS, else white. `centroid`: at an edge nothing is seen that is not between the corners.

#ifdef COLORS
centroid in vec4 tint;
#else
const vec4 tint = vec4(1.0);
#endif

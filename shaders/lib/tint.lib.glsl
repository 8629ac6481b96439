// Factor on a surface's colour, and its opacity in alpha: its vertex colours with COLORS, else white.
// `centroid` keeps interpolation inside the triangle at its edges.

#ifdef COLORS
centroid in vec4 tint;
#else
const vec4 tint = vec4(1.0);
#endif

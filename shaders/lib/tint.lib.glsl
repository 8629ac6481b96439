// The tint of a surface: a factor on its color, and its opacity in alpha. With COLORS it comes from the vertex colors,
// else it is white. `centroid` keeps the interpolation inside the triangle at its edges.

#ifdef COLORS
centroid in vec4 tint;
#else
const vec4 tint = vec4(1.0);
#endif

// The signed circle of confusion (coc): diameter in pixels, negative in front of the focus. It is linear in 1 / depth;
// a tilted or split focus adds an offset at each pixel (lib/focus_offset.lib.glsl).

#include "lib/focus_offset.lib.glsl"  // focus_offset_at

uniform float at_infinity_px;  // diameter of a point infinitely far away
uniform float per_dioptre_px;  // change of the diameter per dioptre (1/m)

// The coc of a point at this planar depth, at a pixel.
float coc_of(float depth_m, ivec2 at) { return at_infinity_px + per_dioptre_px / depth_m + focus_offset_at(at); }

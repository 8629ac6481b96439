// The signed circle of confusion: a line over 1/z, and what a lens that leans adds to it.

#include "lib/lean.lib.glsl"

uniform float at_infinity_px;  // diameter of a point infinitely far away
uniform float per_dioptre_px;  // change of the diameter per dioptre (1/m)

float coc_of(float depth_m, ivec2 at) { return at_infinity_px + per_dioptre_px / depth_m + lean_at(at); }

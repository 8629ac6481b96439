// The signed circle of confusion: a line over 1/z, plus the offset of a tilted focus plane.

#include "lib/focus_offset.lib.glsl"

uniform float at_infinity_px;  // diameter of a point infinitely far away
uniform float per_dioptre_px;  // change of the diameter per dioptre (1/m)

float coc_of(float depth_m, ivec2 at) { return at_infinity_px + per_dioptre_px / depth_m + focus_offset_at(at); }

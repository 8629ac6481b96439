// Focus offset at a pixel, from the tilt of a lens and a split diopter (core/model/focus/coc.py: Lean). Python
// gives the unit: dioptres, or pixels of coc.

uniform vec3 lean_slope;   // of a tilt, for each pixel right and down, and at the picture's corner
uniform vec3 lean_edge;    // share of the split, before it is limited to 0..1 and smoothed
uniform float lean_split;

float lean_at(vec2 px) {
    vec3 place = vec3(px, 1.0);
    return dot(lean_slope, place) + lean_split * smoothstep(0.0, 1.0, dot(lean_edge, place));
}

float lean_at(ivec2 at) { return lean_at(vec2(at) + 0.5); }

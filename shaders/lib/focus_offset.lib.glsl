// Focus offset at a pixel, from the tilt of a lens and a split diopter (core/model/focus/coc.py: FocusOffset).
// Python gives the unit: dioptres, or pixels of coc.

uniform vec3 focus_offset_slope;   // of a tilt, for each pixel right and down, and at the picture's corner
uniform vec3 focus_offset_edge;    // share of the split, before it is limited to 0..1 and smoothed
uniform float focus_offset_split;

float focus_offset_at(vec2 px) {
    vec3 position = vec3(px, 1.0);
    return dot(focus_offset_slope, position) +
           focus_offset_split * smoothstep(0.0, 1.0, dot(focus_offset_edge, position));
}

float focus_offset_at(ivec2 at) { return focus_offset_at(vec2(at) + 0.5); }

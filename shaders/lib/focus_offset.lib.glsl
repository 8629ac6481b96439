// Focus offset at a pixel: by how much its focus is nearer than in the middle of the picture, from the tilt of a lens
// and a split diopter (core/model/focus/coc.py: FocusOffset). The uniforms from Python determine the unit: dioptres,
// or pixels of the circle of confusion. Each triple has the terms for each pixel right, each pixel down, and the
// picture's first corner.

uniform vec3 focus_offset_slope;   // offset of the tilt
uniform vec3 focus_offset_edge;    // share of the split that a pixel has, before it is limited to 0..1 and smoothed
uniform float focus_offset_split;  // offset of the split where its share is 1

// Offset at a position in pixels; the middle of the first pixel is (0.5, 0.5).
float focus_offset_at(vec2 px) {
    vec3 position = vec3(px, 1.0);
    return dot(focus_offset_slope, position) +
           focus_offset_split * smoothstep(0.0, 1.0, dot(focus_offset_edge, position));
}

// Offset at the middle of a pixel.
float focus_offset_at(ivec2 at) { return focus_offset_at(vec2(at) + 0.5); }

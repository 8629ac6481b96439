// A part of the lens, as seen from a position in the picture (render/defocus/lens_parts.py). With PART_VARIES it
// differs over the picture.
//   xy   how far a point moves in the view of this part, for each pixel of its circle of confusion
//   z    diameter of the part, relative to that of the lens
//   w    its share of the light

#ifdef PART_VARIES
uniform vec4 lens_part[PART_GRID_SIDE * PART_GRID_SIDE];  // at positions from corner to corner, row by row

// The part seen from a pixel of a picture of this size, interpolated bilinearly.
vec4 lens_part_at(ivec2 at, ivec2 size) {
    vec2 grid_position = (vec2(at) + 0.5) / vec2(size) * float(PART_GRID_SIDE - 1);
    ivec2 low = ivec2(grid_position);
    vec2 fraction = grid_position - vec2(low);
    int first = low.y * PART_GRID_SIDE + low.x, below = first + PART_GRID_SIDE;
    vec4 upper = mix(lens_part[first], lens_part[first + 1], fraction.x);
    return mix(upper, mix(lens_part[below], lens_part[below + 1], fraction.x), fraction.y);
}
#else
uniform vec4 lens_part;

vec4 lens_part_at(ivec2 at, ivec2 size) { return lens_part; }
#endif

// A part of the lens, seen from a position in the picture: xy movement of a point for each pixel of its coc, z diameter
// of the part relative to that of the lens, w its share of the light (render/defocus/lens_parts.py).

#ifdef PART_VARIES
uniform vec4 lens_part[PART_PLACES * PART_PLACES];  // at places from corner to corner, row by row

vec4 lens_part_at(ivec2 at, ivec2 size) {
    vec2 grid_position = (vec2(at) + 0.5) / vec2(size) * float(PART_PLACES - 1);
    ivec2 low = ivec2(grid_position);
    vec2 fraction = grid_position - vec2(low);
    int first = low.y * PART_PLACES + low.x, below = first + PART_PLACES;
    vec4 upper = mix(lens_part[first], lens_part[first + 1], fraction.x);
    return mix(upper, mix(lens_part[below], lens_part[below + 1], fraction.x), fraction.y);
}
#else
uniform vec4 lens_part;

vec4 lens_part_at(ivec2 at, ivec2 size) { return lens_part; }
#endif

// An opening given by a picture instead of a diaphragm. core/model/lens/opening_image.py is its twin on the CPU and
// explains the table.
//
// The picture is a grid of IMAGE_SIDE x IMAGE_SIDE cells, the box around the round opening. The table has, for each
// corner of a cell, the sum of the light of all cells above and to the left, in whole numbers. The light in a box is a
// difference of such sums. Points p are in radii of the opening, x to the right and y up.
//
// The barrel of the lens cuts the opening off by two circles, which move apart towards the corners of the picture.

uniform usampler2D aperture_image_tx;  // the table, (IMAGE_SIDE + 1)^2 texels
uniform float aperture_image_scale;    // from the table's numbers to light whose mean over the circle is 1
// Share of the light that the barrel lets pass: x in front of the focus, y behind it. Entries differ by the shift of
// the circles: rows by its y, from the most negative to the most positive; columns by its x, from 0 to the most.
uniform vec2 aperture_image_passed[(2 * BARREL_STEPS + 1) * (BARREL_STEPS + 1)];

#define BELOW_ONE 0.999999  // the largest coordinate in the unit square

// An entry of the table.
uint image_sum(int column, int row) {
    return texelFetch(aperture_image_tx, min(ivec2(column, row), IMAGE_SIDE), 0).r;
}

// The light of all cells above a row of corners, in three strips of columns: from corner from_to.x to the next one, on
// to corner from_to.y, and from there to the next one. Differences of whole numbers are exact.
ivec3 strips(ivec2 from_to, int row) {
    uint first = image_sum(from_to.x, row), second = image_sum(from_to.x + 1, row);
    uint third = image_sum(from_to.y, row), fourth = image_sum(from_to.y + 1, row);
    return ivec3(int(second - first), int(third - second), int(fourth - third));
}

// The mean light in a box around a point. `half_sides` are half its width and height, in radii. A box is at least as
// large as a cell, so that large discs show no steps. Cells partly in the box count in proportion.
float image_light(vec2 p, vec2 half_sides) {
    vec2 halves = max(half_sides * float(IMAGE_SIDE) * 0.5, 0.5);
    vec2 at = (p * vec2(0.5, -0.5) + 0.5) * float(IMAGE_SIDE);
    vec2 low = clamp(at - halves, 0.0, float(IMAGE_SIDE)), high = clamp(at + halves, 0.0, float(IMAGE_SIDE));
    ivec2 first = ivec2(low), last = ivec2(high);
    vec2 before = 1.0 - fract(low), after = fract(high);
    ivec2 columns = ivec2(first.x, last.x);
    ivec3 top = strips(columns, first.y), upper = strips(columns, first.y + 1);
    ivec3 lower = strips(columns, last.y), bottom = strips(columns, last.y + 1);
    vec3 across = vec3(before.x, 1.0, after.x);
    float sum = before.y * dot(vec3(upper - top), across) + dot(vec3(lower - upper), across)
              + after.y * dot(vec3(bottom - lower), across);
    return max(sum, 0.0) * aperture_image_scale / (4.0 * halves.x * halves.y);
}

// Share of the light that the barrel lets pass, from the table above, interpolated. `shift` is that of its circles.
float image_transmission(vec2 shift, bool is_behind) {
    if (shift.x < 0.0) shift = -shift;  // both circles shift, to opposite sides: -shift is the same opening
    vec2 at = clamp(shift / aperture_shift_most, vec2(0.0, -1.0), vec2(1.0)) + vec2(0.0, 1.0);
    at *= float(BARREL_STEPS);
    ivec2 low = min(ivec2(at), ivec2(BARREL_STEPS - 1, 2 * BARREL_STEPS - 1));
    vec2 fraction = at - vec2(low);
    int corner = low.y * (BARREL_STEPS + 1) + low.x;
    vec2 above = mix(aperture_image_passed[corner], aperture_image_passed[corner + 1], fraction.x);
    corner += BARREL_STEPS + 1;
    vec2 below = mix(aperture_image_passed[corner], aperture_image_passed[corner + 1], fraction.x);
    vec2 passed = mix(above, below, fraction.y);
    return is_behind ? passed.y : passed.x;
}

// Maps a point of the unit square to the opening, so that equal areas become equal light. The square's y selects the
// row of cells and x the cell in it, each by bisection in the table.
vec2 image_point(vec2 square) {
    vec2 wanted = min(square, BELOW_ONE);
    float level = wanted.y * float(image_sum(IMAGE_SIDE, IMAGE_SIDE));
    int row = 0, column = 0;
    for (int step = IMAGE_SIDE / 2; step > 0; step /= 2)
        if (float(image_sum(IMAGE_SIDE, row + step)) <= level) row += step;
    float above = float(image_sum(IMAGE_SIDE, row)), below = float(image_sum(IMAGE_SIDE, row + 1));
    float fraction_y = (level - above) / max(below - above, 1.0);
    level = wanted.x * float(image_sum(IMAGE_SIDE, row + 1) - image_sum(IMAGE_SIDE, row));
    for (int step = IMAGE_SIDE / 2; step > 0; step /= 2)
        if (float(image_sum(column + step, row + 1) - image_sum(column + step, row)) <= level) column += step;
    float left = float(image_sum(column, row + 1) - image_sum(column, row));
    float right = float(image_sum(column + 1, row + 1) - image_sum(column + 1, row));
    vec2 at = vec2(column, row) + vec2((level - left) / max(right - left, 1.0), fraction_y);
    return (at * (2.0 / float(IMAGE_SIDE)) - 1.0) * vec2(1.0, -1.0);
}

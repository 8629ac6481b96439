// Share of a pixel that the disc of a highlight covers. Small discs are sampled at several points of each pixel,
// because their rim bends within a pixel. If it were taken as straight, a growing disc would grow in steps, from one
// ring of pixels to the next. Include lib/aperture.lib.glsl with SOFT_RIM first.
//
//   offset     from the center of the disc to the pixel, in pixels
//   radius     of the disc in pixels; negative in front of the focus
//   ramp       half the width, in pixels, of the soft edge over which the coverage falls from 1 to 0
//   position   of the disc's center in the picture, pixels
//   Cover      share of light that the pixel gets, 0..1, in one color or in three

#define FINE_ACROSS 3           // number of points across a pixel, and of points down
#define FINE_RADIUS_PX 3.0      // radius up to which the points are spread over the whole pixel
#define COARSE_RADIUS_PX 4.0    // radius from which there is one point; in between the points move together

// Share of a pixel at an offset from the disc's center that the disc covers.
Cover pixel_coverage(vec2 offset, float radius, float ramp, vec2 position) {
    float spacing = 1.0 - smoothstep(FINE_RADIUS_PX, COARSE_RADIUS_PX, abs(radius));
    // A ramp of half width w has the variance w^2 / 3. The points are spread, which is a part of that variance, so that
    // the ramp of each point has to be narrower.
    float points_variance = spacing * spacing * (1.0 - 1.0 / float(FINE_ACROSS * FINE_ACROSS)) / 12.0;
    float point_ramp = spacing > 0.0 ? sqrt(max(ramp * ramp - 3.0 * points_variance, 1e-3)) : ramp;
    rim_softness = spacing;  // of lib/aperture.lib.glsl: 1 a smooth edge, 0 a linear one
    int points = spacing > 0.0 ? FINE_ACROSS * FINE_ACROSS : 1, i = 0;
    Cover sum = Cover(0.0);
    do {  // once for a large disc: a loop with a fixed number of rounds would be unrolled, which is slower
        vec2 point = (vec2(i % FINE_ACROSS, i / FINE_ACROSS) + 0.5) / float(FINE_ACROSS) - 0.5;
        sum += aperture_coverage(offset + spacing * point, radius, point_ramp, position);
    } while (++i < points);
    return sum / float(points);
}

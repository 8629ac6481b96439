// Share of a pixel that the disc of a highlight covers. With FINE_RIMS small discs are sampled at several
// points of each pixel, because a rim one pixel wide makes a disc of hardly more than a pixel too soft.
// Include lib/aperture.lib.glsl first.

#ifdef FINE_RIMS
#define FINE_ACROSS 3          // points across a pixel, each way
#define FINE_RADIUS_PX 4.0     // largest radius of a small disc

Cover pixel_coverage(vec2 offset, float radius, float ramp, vec2 place) {
    if (abs(radius) > FINE_RADIUS_PX) return aperture_coverage(offset, radius, ramp, place);
    // The variance of the pixel's box, plus that of the light itself, gives the ramp.
    float of_light = max(ramp * ramp / 3.0 - 1.0 / 12.0, 0.0);
    float narrow = sqrt(3.0 * (of_light + 1.0 / (12.0 * float(FINE_ACROSS * FINE_ACROSS))));
    Cover sum = Cover(0.0);
    for (int i = 0; i < FINE_ACROSS * FINE_ACROSS; ++i) {
        vec2 aside = (vec2(i % FINE_ACROSS, i / FINE_ACROSS) + 0.5) / float(FINE_ACROSS) - 0.5;
        sum += aperture_coverage(offset + aside, radius, narrow, place);
    }
    return sum / float(FINE_ACROSS * FINE_ACROSS);
}
#else
Cover pixel_coverage(vec2 offset, float radius, float ramp, vec2 place) {
    return aperture_coverage(offset, radius, ramp, place);
}
#endif

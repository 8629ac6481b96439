// The opening of the lens: the only GPU code that knows its shape. core/model/lens/aperture.py is its twin on the
// CPU; core/model/lens/disc_shape.py and core/model/lens/pupil.py set the uniforms below.
// A circle or an ellipse is here; with SHAPED, every other shape is in lib/shaped_aperture.lib.glsl.
//
// A radius is half a signed circle of confusion, in pixels before squeeze and pixel aspect. An offset runs
// from the centre of a disc, at `place` in the picture, to a pixel, x to the right and y down. In front of
// the focus, where the radius is negative, the image of the opening is upside down. A Cover is the share of
// light that a pixel gets, in one colour or in three.

#include "lib/pi.lib.glsl"

uniform vec2 aperture_axes;  // half axes of the opening: of a disc of radius 1, or of the lens in metres

// Share of a pixel inside the rim, at a distance of `to_rim` pixels from it: a linear ramp of half the width `ramp`.
// With SOFT_RIM the ramp may be smooth, with the same variance, because growing discs would jerk otherwise.
#ifdef SOFT_RIM
#define SMOOTH_WIDTH 1.29099445  // sqrt(5/3), of the linear one
float rim_softness = 0.0;        // 0..1, how smooth it is
float within_rim(float to_rim, float ramp) {
    float smoothly = smoothstep(-SMOOTH_WIDTH * ramp, SMOOTH_WIDTH * ramp, to_rim);
    return mix(clamp((to_rim + ramp) / (2.0 * ramp), 0.0, 1.0), smoothly, rim_softness);
}
#else
float within_rim(float to_rim, float ramp) { return clamp((to_rim + ramp) / (2.0 * ramp), 0.0, 1.0); }
#endif

#ifdef SHAPED
#include "lib/shaped_aperture.lib.glsl"
#else
#define Cover float
#define CENTRE_PX 1e-6  // distance up to which a point is the centre, which has no direction to the rim

// Share of the pixel at an offset that is covered, 0..1. `ramp` is half the width of the rim in pixels
// of the picture. The distance to the rim is a first-order estimate: implicit function over gradient.
Cover aperture_coverage(vec2 offset, float radius, float ramp, vec2 place) {
    vec2 unsqueezed = offset / aperture_axes;
    float from_centre = max(length(unsqueezed), CENTRE_PX);
    float gradient = length(unsqueezed / aperture_axes) / from_centre;
    if (from_centre <= CENTRE_PX) gradient = 1.0 / min(aperture_axes.x, aperture_axes.y);
    return within_rim((abs(radius) - from_centre) / gradient, ramp);
}

// Half the width and height of the box around a disc, without what a smooth ramp adds (0.3 of the ramp).
vec2 aperture_reach(float radius, float ramp) { return abs(radius) * aperture_axes + ramp; }

// The least distance from the centre to the box, of any colour.
float aperture_least_reach(float radius, float ramp) {
    vec2 reach = aperture_reach(radius, ramp);
    return min(reach.x, reach.y);
}

// The sum of the coverage over all pixels of a large disc.
Cover aperture_light(float radius, float ramp, vec2 place) {
    return PI * (radius * radius * aperture_axes.x * aperture_axes.y + ramp * ramp / 3.0);
}

// A disc no wider than a pixel is that pixel and nothing else.
bool is_one_pixel(float radius) {
    return abs(radius) * max(aperture_axes.x, aperture_axes.y) <= 0.5;
}

vec4 times(Cover cover, vec4 color) { return cover * color; }
float most_of(Cover cover) { return cover; }
float green_of(Cover cover) { return cover; }
#endif

// The variance of a disc along x and y, in pixels^2, for the ellipse of the same width.
vec2 aperture_variances(float radius) {
    return radius * radius / 4.0 * aperture_axes * aperture_axes;
}

// Maps the unit square to the ellipse around the opening; the map preserves area ratios.
vec2 aperture_point(vec2 square) {
    float angle = 2.0 * PI * square.y;
    return aperture_axes * sqrt(square.x) * vec2(cos(angle), sin(angle));
}

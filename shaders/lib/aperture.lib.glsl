// The opening of the lens, and its image: the disc that a point out of focus becomes. This is the only GPU code that
// knows the shape of the opening. core/model/lens/aperture.py is its twin on the CPU; core/model/lens/disc_shape.py
// and core/model/lens/pupil.py set the uniforms below.
// A circle or an ellipse is here; with SHAPED, every other shape is in lib/shaped_aperture.lib.glsl.
//
//   radius     half a signed circle of confusion, in pixels before squeeze and pixel aspect. In front of the focus it
//              is negative, and the image of the opening is upside down.
//   position   of the disc's center in the picture, pixels
//   offset     from the center of the disc to a pixel, in pixels, x to the right and y down
//   ramp       half the width, in pixels, of the soft edge (rim) of a disc, over which its coverage falls from 1 to 0
//   Cover      share of light that a pixel gets, 0..1, in one color or in three

#include "lib/pi.lib.glsl"  // PI

uniform vec2 aperture_axes;  // half axes of the opening: of a disc of radius 1, or of the lens in meters

// Share of a pixel inside the rim. `to_rim` is the distance from the rim in pixels, positive inside. The share is
// linear over the soft edge, from 0 at -ramp to 1 at +ramp. With SOFT_RIM it may be smooth, with the same variance,
// because growing discs would jerk otherwise.
#define SMOOTH_WIDTH 1.29099445  // sqrt(5/3): width of the smooth edge, relative to a linear one of equal variance
#ifdef SOFT_RIM
float rim_softness = 0.0;        // 0 linear .. 1 smooth
float within_rim(float to_rim, float ramp) {
    float smoothly = smoothstep(-SMOOTH_WIDTH * ramp, SMOOTH_WIDTH * ramp, to_rim);
    return mix(clamp((to_rim + ramp) / (2.0 * ramp), 0.0, 1.0), smoothly, rim_softness);
}
#else
float within_rim(float to_rim, float ramp) { return clamp((to_rim + ramp) / (2.0 * ramp), 0.0, 1.0); }
#endif

#ifdef SHAPED
#include "lib/shaped_aperture.lib.glsl"  // to_rim
#else
#define Cover float
#define CENTER_PX 1e-6  // distance up to which a point is the center, which has no direction to the rim

// Share of the pixel at an offset that the disc covers, 0..1. The distance to the rim is a first-order estimate:
// the implicit function of the ellipse, divided by the length of its gradient.
Cover aperture_coverage(vec2 offset, float radius, float ramp, vec2 position) {
    vec2 unsqueezed = offset / aperture_axes;
    float from_center = max(length(unsqueezed), CENTER_PX);
    float gradient = length(unsqueezed / aperture_axes) / from_center;
    if (from_center <= CENTER_PX) gradient = 1.0 / min(aperture_axes.x, aperture_axes.y);
    return within_rim((abs(radius) - from_center) / gradient, ramp);
}

// Half the width and height of the box around a disc, in pixels. A smooth edge reaches 0.3 ramp beyond this box.
vec2 aperture_reach(float radius, float ramp) { return abs(radius) * aperture_axes + ramp; }

// The least distance from the center to a side of that box, in pixels.
float aperture_least_reach(float radius, float ramp) {
    vec2 reach = aperture_reach(radius, ramp);
    return min(reach.x, reach.y);
}

// The sum of the coverage over all pixels of a large disc, pixels^2. The term with `ramp` is the light that the soft
// edge adds to a round disc.
Cover aperture_light(float radius, float ramp, vec2 position) {
    return PI * (radius * radius * aperture_axes.x * aperture_axes.y + ramp * ramp / 3.0);
}

// A disc no wider than a pixel is that pixel and nothing else.
bool is_one_pixel(float radius) {
    return abs(radius) * max(aperture_axes.x, aperture_axes.y) <= 0.5;
}

// For a Cover of one color or of three: the product with rgba, the largest component, and green.
vec4 times(Cover cover, vec4 color) { return cover * color; }
float most_of(Cover cover) { return cover; }
float green_of(Cover cover) { return cover; }
#endif

// The variance of a disc along x and y, in pixels^2. Any opening counts as the ellipse with the same axes.
vec2 aperture_variances(float radius) {
    return radius * radius / 4.0 * aperture_axes * aperture_axes;
}

// Maps the unit square to the ellipse around the opening; the map preserves area ratios.
vec2 aperture_point(vec2 square) {
    float angle = 2.0 * PI * square.y;
    return aperture_axes * sqrt(square.x) * vec2(cos(angle), sin(angle));
}

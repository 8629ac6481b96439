// The part of lib/aperture.lib.glsl for openings that are not ellipses: with blades, cut off by the barrel of the
// lens, brighter or darker at the rim, or different for each color. core/model/lens/opening.py is its twin on the CPU
// and explains the formulas. With IMAGED a picture replaces the blades, see lib/opening_image.lib.glsl.
//
//   p                   a point of the opening, in radii of the round lens before the squeeze, x right and y up
//   position            position in the picture from which the opening is seen, pixels
//   radius, ramp, offset, Cover   as in lib/aperture.lib.glsl; a Cover here has red, green and blue, which differ
//                       with COLORED
//   rim                 brightness of the rim on one side of the focus: 1 bright, 0 even, -1 soft
//   distance            x signed distance of a point from an edge, in radii, negative inside; yz its gradient
//   shift               shift of the barrel's circles, in radii
//
// The barrel ends in a circle at the front and another at the back. Seen from off the middle of the picture they
// shift to opposite sides, and light has to pass both.
//
// Functions called for each pixel of a disc contain no loops, because a software rasterizer stops an invocation after
// 65535 loop iterations in all.

#define Cover vec3

uniform int aperture_blades;           // 0: round
uniform float aperture_turn;           // angle of the first corner, radians
uniform float aperture_curvature;      // 0 straight blades, 1 round
uniform float aperture_rim;            // `rim` behind the focus; in front of it the sign is reversed
uniform vec2 aperture_lights;          // light of the opening in front of the focus, and behind it: pi for a round one
uniform float aperture_barrel;         // radius of the barrel's circles; 0 for none
uniform vec2 aperture_middle_px;       // middle of the picture
uniform vec2 aperture_shift_per_px;    // shift of the barrel's circles for each pixel of distance from there
uniform float aperture_shift_most;     // shift at the corners of the picture; it does not grow beyond
uniform float aperture_axial_px;       // diameter in blue minus that in green, and in green minus that in red

#ifdef IMAGED
#include "lib/opening_image.lib.glsl"  // image_light, image_transmission
#endif

#define TINY 1e-12         // avoids a division by 0
#define ANGLES 64          // angles of the quadrature over the opening
#define LEAST_RADIUS 1e-3  // a smaller disc is drawn round

// True if the opening has blades, or a barrel. `value` is any number that differs from pixel to pixel: where a
// condition asks for uniforms alone, lavapipe of Mesa 22 builds the program anew for each run and never frees it.
bool has_blades(float value) { return abs(value) < 1e30 && aperture_blades > 0; }
bool has_barrel(float value) { return abs(value) < 1e30 && aperture_barrel > 0.0; }

// Shift of the barrel's circles, seen from a position in the picture: one circle shifts by it, the other by its
// opposite.
vec2 barrel_shift(vec2 position) {
    vec2 shift = (position - aperture_middle_px) * aperture_shift_per_px;
    return shift * min(1.0, aperture_shift_most / max(length(shift), 1e-30));
}

// Cosine of the angle by which a curved blade is tilted at its corner; 1 for straight blades. `half_angle` is half the
// angle between two corners, seen from the center.
float straightness(float half_angle) {
    float bent = aperture_curvature * sin(half_angle);
    return sqrt(1.0 - bent * bent);
}

// Signed distance of a point from the edge of the blades, negative inside, in radii, and its gradient.
// `across` and `along` are the point's coordinates outwards from, and along, the chord of its blade. The edge is an arc
// of the given curvature through the two corners: the zeros of bent + straight * across, whose gradient has length 1
// there.
vec3 past_blades(vec2 p) {
    float from_middle = max(length(p), TINY);
    vec3 distance = vec3(from_middle - 1.0, p / from_middle);
    if (has_blades(from_middle)) {
        float half_angle = PI / float(aperture_blades);
        float sector = floor((atan(p.y, from_middle > TINY ? p.x : 1.0) - aperture_turn) / (2.0 * half_angle));
        float middle = aperture_turn + (2.0 * sector + 1.0) * half_angle;
        vec2 outwards = vec2(cos(middle), sin(middle));
        float straight = straightness(half_angle), sine = sin(half_angle);
        float across = dot(p, outwards) - cos(half_angle);
        float along = outwards.x * p.y - outwards.y * p.x;
        float bent = 0.5 * aperture_curvature * (across * across + along * along - sine * sine);
        vec2 gradient = (aperture_curvature * across + straight) * outwards;
        gradient += aperture_curvature * along * vec2(-outwards.y, outwards.x);
        distance = vec3(bent + straight * across, gradient);
    }
    return distance;
}

// Signed distance of a point from the edge of the barrel, negative inside, in radii, and its gradient. The circle
// that is farther from the point decides.
vec3 past_barrel(vec2 p, vec2 shift) {
    vec2 shifted = p + (dot(p, shift) < 0.0 ? -shift : shift);
    float from_middle = max(length(shifted), TINY);
    return vec3(from_middle - aperture_barrel, shifted / from_middle);
}

// Brightness at a squared distance from the center, in radii^2; its mean over the round opening is 1.
float profile(float square, float rim) {
    float bright = rim > 0.0 ? square : 1.0 - square;
    return 1.0 + RIM_MOST * abs(rim) * (float(RIM_POWER + 1) * pow(max(bright, 0.0), float(RIM_POWER)) - 1.0);
}

// Distance of a point from the edge, positive inside, after the squeeze: for an opening with these half axes. It is a
// first-order estimate: the distance before the squeeze, divided by the length of its gradient after it.
float to_rim(vec3 distance, vec2 axes) { return -distance.x / max(length(distance.yz / axes), 1e-6); }

// Share of light of one color that the pixel at an offset gets. A tiny radius is enlarged, because the offset is
// divided by it.
float cover_of_color(vec2 offset, float radius, float ramp, vec2 position) {
    if (abs(radius) < LEAST_RADIUS) radius = radius < 0.0 ? -LEAST_RADIUS : LEAST_RADIUS;
    vec2 p = offset / (aperture_axes * radius) * vec2(1.0, -1.0);
#ifdef IMAGED
    float inside = image_light(p, ramp / (aperture_axes * abs(radius)));
    if (has_barrel(inside)) {
        float to_barrel = to_rim(past_barrel(p, barrel_shift(position)), aperture_axes);
        inside *= within_rim(to_barrel * abs(radius), ramp);
    }
#else
    float inside = to_rim(past_blades(p), aperture_axes);
    if (has_barrel(inside))
        inside = min(inside, to_rim(past_barrel(p, barrel_shift(position)), aperture_axes));
    inside = within_rim(inside * abs(radius), ramp);
#endif
    return inside * profile(min(dot(p, p), 1.0), radius < 0.0 ? -aperture_rim : aperture_rim);
}

// Distance from the center to the edge of the blades in a direction, in radii; `angle` in radians. At a distance r in
// this direction, the arc of `past_blades` is where curvature / 2 r^2 + linear r - constant = 0.
float blade_radius(float angle) {
    if (!has_blades(angle)) return 1.0;
    float half_angle = PI / float(aperture_blades), sine = sin(half_angle), cosine = cos(half_angle);
    float straight = straightness(half_angle);
    float angle_from_middle = mod(angle - aperture_turn, 2.0 * half_angle) - half_angle;
    float linear = (straight - aperture_curvature * cosine) * cos(angle_from_middle);
    float constant = straight * cosine - 0.5 * aperture_curvature * (cosine * cosine - sine * sine);
    return 2.0 * constant / (linear + sqrt(linear * linear + 2.0 * aperture_curvature * constant));
}

// Distance from the center to the edge of the barrel in a direction, in radii; `direction` is unit. It is the positive
// root of |r direction + shift| = aperture_barrel, for the circle that is reached first.
float barrel_radius(vec2 direction, vec2 shift) {
    float along = abs(dot(direction, shift));
    return sqrt(along * along + aperture_barrel * aperture_barrel - dot(shift, shift)) - along;
}

// Light within the distance `reach` from the center in radii, as a share of that of the round lens: the integral of
// `profile`.
float light_to(float reach, float rim) {
    float square = reach * reach;
    float bright = rim < 0.0 ? 1.0 - pow(max(1.0 - square, 0.0), float(RIM_POWER + 1)) : pow(square, float(RIM_POWER + 1));
    return mix(square, bright, RIM_MOST * abs(rim));
}

// Share of the light through the blades that also passes the barrel, 0..1, by a sum over angles.
float barrel_transmission(vec2 position, float rim) {
    vec2 shift = barrel_shift(position);
    float all = 0.0, passed_light = 0.0;
    for (int k = 0; k < ANGLES; ++k) {
        float angle = (float(k) + 0.5) * 2.0 * PI / float(ANGLES), reach = blade_radius(angle);
        all += light_to(reach, rim);
        passed_light += light_to(min(reach, barrel_radius(vec2(cos(angle), sin(angle)), shift)), rim);
    }
    return passed_light / all;
}

// The sum of the coverage over all pixels of a disc of one color, pixels^2. Without an image the last term is the
// light that the soft edge adds, exact for a round disc.
float light_of_color(float radius, float ramp, vec2 position) {
    float light = radius < 0.0 ? aperture_lights.x : aperture_lights.y;
#ifdef IMAGED  // the soft edge of an image is a mean over boxes, which keeps the light: no term for the ramp
    if (has_barrel(light)) light *= image_transmission(barrel_shift(position), radius >= 0.0);
    return max(radius * radius, LEAST_RADIUS * LEAST_RADIUS) * light * aperture_axes.x * aperture_axes.y;
#else
    float rim = radius < 0.0 ? -aperture_rim : aperture_rim;
    if (has_barrel(light)) light *= barrel_transmission(position, rim);
    return radius * radius * light * aperture_axes.x * aperture_axes.y + PI * ramp * ramp / 3.0;
#endif
}

// Radii of the disc in red, green and blue.
vec3 radii_of_colors(float radius) { return radius + 0.5 * aperture_axial_px * vec3(-1.0, 0.0, 1.0); }

// Share of light that the pixel at an offset gets.
Cover aperture_coverage(vec2 offset, float radius, float ramp, vec2 position) {
    vec3 cover = vec3(cover_of_color(offset, radius, ramp, position));
#ifdef COLORED
    vec3 radii = radii_of_colors(radius);
    cover.r = cover_of_color(offset, radii.r, ramp, position);
    cover.b = cover_of_color(offset, radii.b, ramp, position);
#endif
    return cover;
}

// The sum of the coverage over all pixels of a disc.
Cover aperture_light(float radius, float ramp, vec2 position) {
    vec3 light = vec3(light_of_color(radius, ramp, position));
#ifdef COLORED
    vec3 radii = radii_of_colors(radius);
    light.r = light_of_color(radii.r, ramp, position);
    light.b = light_of_color(radii.b, ramp, position);
#endif
    return light;
}

// Half the width and height of the box around a disc in all its colors, in pixels.
vec2 aperture_reach(float radius, float ramp) {
    return (abs(radius) + 0.5 * abs(aperture_axial_px)) * aperture_axes + ramp;
}

// The least distance from the center to a side of the box around the disc of any one color, in pixels.
float aperture_least_reach(float radius, float ramp) {
    return (abs(radius) - 0.5 * abs(aperture_axial_px)) * min(aperture_axes.x, aperture_axes.y) + ramp;
}

// A disc no wider than a pixel in any color is that pixel and nothing else.
bool is_one_pixel(float radius) {
    return (abs(radius) + 0.5 * abs(aperture_axial_px)) * max(aperture_axes.x, aperture_axes.y) <= 0.5;
}

// Weight of a point of the opening for light that goes to a position in the picture, from behind the focus or from
// in front of it; 0 where the light does not pass. With an image only the barrel and the rim count here, because the
// points themselves are denser where the image is brighter.
float aperture_weight(vec2 p, vec2 position, bool is_behind) {
#ifdef IMAGED
    float distance = -1.0;
#else
    float distance = past_blades(p).x;
#endif
    if (has_barrel(distance))
        distance = max(distance, past_barrel(p, barrel_shift(position)).x);
    return distance > 0.0 ? 0.0 : profile(min(dot(p, p), 1.0), is_behind ? aperture_rim : -aperture_rim);
}

// Position in the pinhole picture of a point of the scene that appears at `px` through the point `p` of the opening.
// `radius` times `axes` are the half axes of its disc in pixels; the radius has the sign of the circle of confusion.
vec2 pinhole_position(vec2 px, vec2 p, float radius, vec2 axes) { return px - radius * axes * p * vec2(1.0, -1.0); }

// The product with rgba, where alpha counts as green; green alone; and the largest component.
vec4 times(Cover cover, vec4 color) { return vec4(cover * color.rgb, cover.g * color.a); }
float green_of(Cover cover) { return cover.g; }
float most_of(Cover cover) { return max(cover.r, max(cover.g, cover.b)); }

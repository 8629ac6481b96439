// Draws the disc of a pixel of the picture: adds the pixel's share of light and coverage to each pixel of the disc
// (scatter_draw.vert.glsl).
//
// Outputs (added up for all discs of a bin of depth)
//   out_light   rgba of the picture's pixel, times the share
//   out_cover   r the share; that of green, if the discs of the colors differ in size
//
// From lib/aperture.lib.glsl: Cover is the type of a share. It is a float for round openings, and with SHAPED a vec3 of
// red, green and blue, which differ where the lens has axial color. For both types times() multiplies an rgba by a
// share, and most_of() and green_of() return its largest component and green.

#include "lib/aperture.lib.glsl"  // Cover, aperture_coverage, times, most_of, green_of

flat in vec2 center;
flat in float radius;
flat in Cover share;  // of the light, in a pixel wholly inside the disc; negative: the disc is one pixel
flat in vec4 color;

layout(location = 0) out vec4 out_light;
layout(location = 1) out float out_cover;

void main() {
    Cover disc_share = Cover(1.0);  // a disc of one pixel has all the light there
    if (most_of(share) >= 0.0)
        disc_share = share * aperture_coverage(gl_FragCoord.xy - center, radius, DISC_RAMP_PX, center);
    if (most_of(disc_share) == 0.0) discard;
    out_light = times(disc_share, color);
    out_cover = green_of(disc_share);
}

// Draws a pixel's disc: its share of the pixel's light and coverage, to be added up.

#include "lib/aperture.lib.glsl"

flat in vec2 centre;
flat in float radius;
flat in Cover share;
flat in vec4 color;

layout(location = 0) out vec4 out_light;
layout(location = 1) out float out_cover;

void main() {
    Cover disc_share = Cover(1.0);
    if (most_of(share) >= 0.0)
        disc_share = share * aperture_coverage(gl_FragCoord.xy - centre, radius, DISC_RAMP_PX, centre);
    if (most_of(disc_share) == 0.0) discard;
    out_light = times(disc_share, color);
    out_cover = green_of(disc_share);
}

// Draws a quad around the disc of a pixel of the picture. The pixel's light is scattered over its disc: each pixel
// inside gets the share 1 / (sum of the coverage of all pixels by the disc), so that no light is lost.
//
// Inputs
//   in_pixel      number of the pixel
//   color_tx      rgba of the picture
//   coc_tx        r signed coc (circle of confusion, diameter in pixels, negative in front of the focus)
// Outputs (see below)
//   center, radius, share, color

#include "lib/aperture.lib.glsl"  // Cover, aperture_coverage, aperture_reach, aperture_light, is_one_pixel

in uint in_pixel;  // y * width + x

uniform sampler2D color_tx;
uniform sampler2D coc_tx;
#ifndef SHAPED
uniform float disc_sums[SCATTER_DISC_SUMS];  // sum of the profile over pixels, for each eighth of a pixel of coc
#endif

flat out vec2 center;   // of the disc, pixels
flat out float radius;  // signed, pixels
flat out Cover share;  // share of its light in a pixel wholly inside; -1: all light stays in its own pixel
flat out vec4 color;  // rgba of the pixel

#ifdef SHAPED
#define SUMMED_PX 4.0  // discs up to this radius are summed pixel by pixel

float round_coc(float coc) { return coc; }

// The sum of the coverage of all pixels by a disc.
Cover disc_sum(float coc) {
    vec2 reach = aperture_reach(0.5 * coc, DISC_RAMP_PX);
    if (max(reach.x, reach.y) > SUMMED_PX) return aperture_light(0.5 * coc, DISC_RAMP_PX, center);
    ivec2 last = ivec2(ceil(reach));
    Cover sum = Cover(0.0);
    for (int y = -last.y; y <= last.y; ++y)
        for (int x = -last.x; x <= last.x; ++x)
            sum += aperture_coverage(vec2(x, y), 0.5 * coc, DISC_RAMP_PX, center);
    return sum;
}
#else
// The coc of a small disc is rounded to 1 / STEPS_A_PX pixels, so that its sum is in the table disc_sums and no light
// is lost. The sign of a round disc does not count.
#define STEPS_A_PX float(SCATTER_STEPS_A_PX)

float round_coc(float coc) {
    coc = abs(coc);
    return int(round(coc * STEPS_A_PX)) < SCATTER_DISC_SUMS ? round(coc * STEPS_A_PX) / STEPS_A_PX : coc;
}

Cover disc_sum(float coc) {
    int step = int(round(coc * STEPS_A_PX));
    if (step < SCATTER_DISC_SUMS) return disc_sums[step];
    return aperture_light(0.5 * coc, DISC_RAMP_PX, center);
}
#endif

void main() {
    ivec2 size = textureSize(color_tx, 0);
    ivec2 at = ivec2(int(in_pixel) % size.x, int(in_pixel) / size.x);
    float coc = texelFetch(coc_tx, at, 0).r;
    bool sharp = is_one_pixel(0.5 * coc);
    coc = round_coc(coc);
    color = texelFetch(color_tx, at, 0);
    center = vec2(at) + 0.5;
    radius = 0.5 * coc;
    share = sharp ? Cover(-1.0) : 1.0 / disc_sum(coc);
    vec2 corner = vec2(gl_VertexID % 2, gl_VertexID / 2) * 2.0 - 1.0;
    vec2 reach = sharp ? vec2(0.5) : aperture_reach(radius, DISC_RAMP_PX);
    gl_Position = vec4((center + corner * reach) / vec2(size) * 2.0 - 1.0, 0.0, 1.0);
}

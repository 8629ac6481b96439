// Highlights of small things, and their rims, which anti-aliasing has mixed into pixels of what is behind. Diffused, the
// light of a snowflake in front of a blurred wall would spread as the wall's does, and its rim would stay where it is in
// front of a sharp one.
//
//   around   luminance of the surroundings, clipped to 0..1 (highlight_luminance.comp.glsl)
//   coc      signed circle of confusion, diameter in pixels, negative in front of the focus
//
// Part of highlight_split.comp.glsl, after lib/highlight_limit.lib.glsl.
//
// Inputs
//   color_tx   scene-linear rgb
//   coc_tx     r coc

#define RIM_FROM_PX 1.0   // difference in coc from which a thing is in front of what is beside it
#define RIM_FULL_PX 3.0   // difference from which it is wholly so
#define RIM_COVERAGE 0.5  // largest coverage of a pixel by a nearer thing that the depth sample missed
#define SPECK_FROM 0.05   // light of a rim, relative to the surroundings, from which it would show as a speck
#define SPECK_FULL 0.15   // light from which all of it is taken
#define DARK 0.05         // added to these surroundings
#define SMALL_PX 5        // distance at which something farther is seen on all sides of a small thing
#define SIDES_FROM 6.0    // number of the eight sides from which the thing may be small
#define SIDES_FULL 8.0    // number from which it is
#define SMALL_FROM 0.35   // luminance, above that of the surroundings, from which a small thing is a highlight
#define SMALL_FULL 0.5    // luminance from which all is that exceeds the surroundings

uniform sampler2D color_tx;
uniform sampler2D coc_tx;

// What is seen in 3 x 3 pixels of the picture around a pixel.
struct Seen {
    vec4 brightest;  // rgb of the pixel of most luminance, a its coc
    ivec2 pixel;     // that pixel
    vec3 own;        // rgb of the darkest pixel of the same surface
};

// If not `is_searched`, the loop ends after one round and the result is not used.
Seen look_around(ivec2 at, float coc, bool is_searched) {
    ivec2 last = textureSize(color_tx, 0) - 1;
    vec3 x = texelFetch(color_tx, at, 0).rgb;
    Seen seen = Seen(vec4(x, coc), at, x);
    int k = 0;
    do {
        ivec2 p = clamp(at + ivec2(k % 3, k / 3) - 1, ivec2(0), last);
        vec4 other = vec4(texelFetch(color_tx, p, 0).rgb, texelFetch(coc_tx, p, 0).r);
        float luminance = mean_of(other.rgb);
        if (luminance > mean_of(seen.brightest.rgb)) {
            seen.brightest = other;
            seen.pixel = p;
        }
        if (luminance < mean_of(seen.own) && abs(other.a - coc) < RIM_FROM_PX) seen.own = other.rgb;
    } while (is_searched && ++k < 9);
    return seen;
}

// True if something nearer is seen left, right, above or below.
bool is_beside_nearer(ivec2 at, float coc) {
    vec2 size = vec2(textureSize(coc_tx, 0));
    vec4 nearest = min(textureGather(coc_tx, vec2(at) / size), textureGather(coc_tx, vec2(at + 1) / size));
    return coc - min(min(nearest.x, nearest.y), min(nearest.z, nearest.w)) > RIM_FROM_PX;
}

// Degree to which a pixel shows a small thing, all around which something farther is seen, 0..1. If not `is_searched`, the
// loop ends after one round and the result is not used.
float small_share(ivec2 at, float coc, bool is_searched) {
    ivec2 last = textureSize(coc_tx, 0) - 1;
    float farther = 0.0;
    int k = 0;
    do {
        ivec2 p = clamp(at + SMALL_PX * (ivec2(k % 3, k / 3) - 1), ivec2(0), last);
        farther += smoothstep(RIM_FROM_PX, RIM_FULL_PX, texelFetch(coc_tx, p, 0).r - coc);
    } while (is_searched && ++k < 9);
    return smoothstep(SIDES_FROM, SIDES_FULL, farther);
}

// Share of the light of a pixel (rgb, a its coc) that belongs to a highlight, 0..1. A small thing is one even if it is
// little brighter than its surroundings: it is no part of a surface that would show the ripple of many discs.
float share_of(ivec2 at, vec4 light, float around) {
    float luminance = mean_of(light.rgb), bright = smoothstep(SMALL_FROM + around, SMALL_FULL + around, luminance);
    float exceeding = max(1.0 - around / max(luminance, 1e-6), 0.0);
    return max(highlight_share(light.rgb, around), bright * small_share(at, light.a, bright > 0.0) * exceeding);
}

// The part of a pixel's light x that is of a nearer highlight beside it, a its coc.
vec4 rim_of(vec3 x, float coc, Seen seen, float around) {
    float own = mean_of(seen.own), luminance = mean_of(seen.brightest.rgb);
    float cover = clamp((mean_of(x) - own) / max(luminance - own, 1e-6), 0.0, RIM_COVERAGE);
    cover *= smoothstep(RIM_FROM_PX, RIM_FULL_PX, coc - seen.brightest.a);
    cover *= smoothstep(SPECK_FROM, SPECK_FULL, cover * luminance / (around + DARK));
    vec3 light = cover * share_of(seen.pixel, seen.brightest, around) * seen.brightest.rgb;
    return vec4(min(light, x), seen.brightest.a);
}

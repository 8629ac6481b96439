// Draws an overlay, which shows over the picture where it is in focus and how much it is blurred. The overlay is
// computed from the depth, one pixel an invocation. It is drawn by one of the functions *_color below (MODE). With
// PEAKING, areas in focus are colored over that.
//
// The coc is the signed circle of confusion: diameter in pixels, negative in front of the focus.
//
// Inputs
//   depth_tx          r depth in meters, or the coc if `is_coc`
//   color_tx          scene-linear rgb of the picture in any size, for the edges of peaking
// Output
//   out_overlay_img   rgb display values with straight alpha

#ifndef MODE
#define MODE zones_color  // the function that the record of an overlay names
#endif
#ifndef PEAKING
#define PEAKING 0  // 1: areas in focus are colored over that
#endif

#include "lib/coc.lib.glsl"  // coc_of

layout(local_size_x = PIXEL_GROUP, local_size_y = PIXEL_GROUP) in;

uniform sampler2D depth_tx;
uniform sampler2D color_tx;
uniform float peaking_contrast;    // least contrast of an edge that is colored, in stops
uniform float peaking_px;          // largest |coc| that is colored
uniform vec3 peaking_rgb;
uniform bool is_peaking_all;       // color the whole area in focus, not only edges
layout(rgba8) uniform writeonly image2D out_overlay_img;
uniform bool is_coc;
uniform float sharp_px;            // a |coc| up to this counts as in focus
uniform vec2 range_px;             // least and greatest coc of the plate
uniform float layer_limits_px[LAYERS_MAX]; // coc between layers, ascending; unused ones are huge

const float TINT = 0.42;        // alpha of a tint: the picture stays readable under it
const float LAYER_TINT = 0.55;  // alpha of the colors of the layers
const float LINE_ALPHA = 0.9;   // alpha of the line at the plane of focus
const float LINE_SHARE = 0.3;   // coc, as a share of sharp_px, at which that line has faded to 1/e
const float DARKEST = 0.06;     // brightness of the least coc that is not sharp

// The coc at a pixel; beyond the border that of the nearest pixel.
float coc_at(ivec2 at) {
    float depth = texelFetch(depth_tx, clamp(at, ivec2(0), textureSize(depth_tx, 0) - 1), 0).r;
    return is_coc ? depth : coc_of(depth, at);
}

// No overlay.
vec4 no_color(ivec2 at, float coc) { return vec4(0.0); }

// Three colors: in focus, in front of the focus, and behind it.
vec4 zones_color(ivec2 at, float coc) {
    vec3 color = abs(coc) <= sharp_px ? OVERLAY_FOCUS : coc < 0.0 ? OVERLAY_NEAR : OVERLAY_FAR;
    return vec4(color, TINT);
}

// 1 if a surface crosses the plane of focus between two pixels with these coc, else 0. Where two surfaces meet, their
// coc differ by more, and none crosses.
float crossing(float own, float other) {
    bool is_one_surface = abs(own - other) < 2.0 * sharp_px;
    return is_one_surface && own * other <= 0.0 ? 1.0 : 0.0;
}

// A line where a surface crosses the plane of focus.
vec4 focus_plane_color(ivec2 at, float coc) {
    float relative_coc = coc / (LINE_SHARE * sharp_px);
    float line = exp(-relative_coc * relative_coc);
    line = max(line, crossing(coc, coc_at(at + ivec2(1, 0))));
    line = max(line, crossing(coc, coc_at(at + ivec2(0, 1))));
    return vec4(OVERLAY_FOCUS_LINE, LINE_ALPHA * line);
}

// The |coc| as brightness, on a logarithmic scale, and the side of the focus as hue.
vec4 coc_color(ivec2 at, float coc) {
    float widest = max(max(-range_px.x, range_px.y), 2.0 * sharp_px);
    float relative_coc = log2(1.0 + abs(coc)) / log2(1.0 + widest);
    vec3 hue = coc < 0.0 ? OVERLAY_COC_NEAR : OVERLAY_COC_FAR;
    return vec4(abs(coc) <= sharp_px ? OVERLAY_COC_SHARP : mix(vec3(DARKEST), hue, relative_coc), 1.0);
}

// Luminance of a pixel of color_tx in stops; 0.002 is added because the logarithm of 0 is infinite.
float light_at(ivec2 at) {
    vec3 light = texelFetch(color_tx, clamp(at, ivec2(0), textureSize(color_tx, 0) - 1), 0).rgb;
    return log2(max(dot(light, vec3(0.2126, 0.7152, 0.0722)), 0.0) + 0.002);
}

// Strength of an edge of the light at a pixel of color_tx, 0 to 1.
float light_edge(ivec2 at) {
    vec2 light = vec2(light_at(at + ivec2(1, 0)) - light_at(at - ivec2(1, 0)),
                      light_at(at + ivec2(0, 1)) - light_at(at - ivec2(0, 1)));
    return smoothstep(peaking_contrast, 2.0 * peaking_contrast, length(light));
}

// Peaking: edges of light and depth in areas in focus; or the whole area, stronger where it is sharper.
vec4 peaking_color(float coc, ivec2 at) {
    if (abs(coc) > peaking_px) return vec4(peaking_rgb, 0.0);
    if (is_peaking_all) return vec4(peaking_rgb, mix(0.7, 0.3, abs(coc) / peaking_px));
    vec2 depth = vec2(coc_at(at + ivec2(1, 0)) - coc_at(at - ivec2(1, 0)),
                      coc_at(at + ivec2(0, 1)) - coc_at(at - ivec2(0, 1)));
    ivec2 in_color = at * textureSize(color_tx, 0) / textureSize(depth_tx, 0);
    return vec4(peaking_rgb, max(light_edge(in_color), step(4.0 * sharp_px, length(depth))));
}

// A color between near and far, linear in the coc.
vec4 depth_color(ivec2 at, float coc) {
    float far = (coc - range_px.x) / max(range_px.y - range_px.x, 1e-6);
    return vec4(mix(OVERLAY_DEPTH_NEAR, OVERLAY_DEPTH_FAR, clamp(far, 0.0, 1.0)), 1.0);
}

// One color for each layer.
vec4 layers_color(ivec2 at, float coc) {
    const vec3 TINTS[LAYERS_MAX + 1] = OVERLAY_LAYERS;
    int layer = 0;
    for (int i = 0; i < LAYERS_MAX; i++) layer += int(coc > layer_limits_px[i]);
    return vec4(TINTS[layer], LAYER_TINT);
}

// Composites one color over another, all with straight alpha.
vec4 over(vec4 front, vec4 back) {
    float alpha = front.a + back.a * (1.0 - front.a);
    vec3 light = front.rgb * front.a + back.rgb * back.a * (1.0 - front.a);
    return vec4(alpha > 0.0 ? light / alpha : front.rgb, alpha);
}

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(at, textureSize(depth_tx, 0)))) return;
    float coc = coc_at(at);
    vec4 color = MODE(at, coc);
#if PEAKING
    color = over(peaking_color(coc, at), color);
#endif
    imageStore(out_overlay_img, at, color);
}

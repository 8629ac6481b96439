// What is drawn over the picture, from depth alone: one pixel an invocation.
//
// Input
//   depth_tx          metres, or signed coc in pixels where `is_coc`
// Output
//   out_overlay_img   display RGB with straight alpha

#ifndef MODE
#define MODE zones_color  // or focus_plane_color, coc_color, depth_color, layers_color
#endif

layout(local_size_x = 16, local_size_y = 16) in;

uniform sampler2D depth_tx;
layout(rgba8) uniform writeonly image2D out_overlay_img;
uniform bool is_coc;
uniform float at_infinity_px;      // signed coc over dioptres: at_infinity + per_dioptre / depth
uniform float per_dioptre_px;
uniform float sharp_px;            // a diameter up to this counts as in focus
uniform vec2 range_px;             // least and greatest signed coc of the plate
uniform float layer_limits_px[7];  // signed coc between layers, ascending; unused ones are huge

const vec3 NEAR_COLOR = vec3(0.95, 0.25, 0.18);
const vec3 FOCUS_COLOR = vec3(0.25, 0.85, 0.35);
const vec3 FAR_COLOR = vec3(0.25, 0.48, 0.98);
const float TINT = 0.42;  // alpha of a tint: the picture stays readable under it

float coc_at(ivec2 at) {
    float depth = texelFetch(depth_tx, clamp(at, ivec2(0), textureSize(depth_tx, 0) - 1), 0).r;
    return is_coc ? depth : at_infinity_px + per_dioptre_px / depth;
}

vec4 zones_color(ivec2 at, float coc) {
    vec3 color = abs(coc) <= sharp_px ? FOCUS_COLOR : coc < 0.0 ? NEAR_COLOR : FAR_COLOR;
    return vec4(color, TINT);
}

// Where a surface runs through the plane between two pixels, not where two surfaces meet.
float crossing(float here, float beside) {
    bool is_one_surface = abs(here - beside) < 2.0 * sharp_px;
    return is_one_surface && here * beside <= 0.0 ? 1.0 : 0.0;
}

vec4 focus_plane_color(ivec2 at, float coc) {
    float nearness = coc / (0.3 * sharp_px);
    float line = exp(-nearness * nearness);
    line = max(line, crossing(coc, coc_at(at + ivec2(1, 0))));
    line = max(line, crossing(coc, coc_at(at + ivec2(0, 1))));
    return vec4(1.0, 0.86, 0.35, 0.9 * line);
}

vec4 coc_color(ivec2 at, float coc) {
    float widest = max(max(-range_px.x, range_px.y), 2.0 * sharp_px);
    float part = log2(1.0 + abs(coc)) / log2(1.0 + widest);
    vec3 hue = coc < 0.0 ? vec3(1.0, 0.55, 0.12) : vec3(0.2, 0.6, 1.0);
    return vec4(abs(coc) <= sharp_px ? vec3(0.10, 0.30, 0.14) : mix(vec3(0.06), hue, part), 1.0);
}

vec4 depth_color(ivec2 at, float coc) {
    float far = (coc - range_px.x) / max(range_px.y - range_px.x, 1e-6);
    return vec4(vec3(1.0 - clamp(far, 0.0, 1.0)), 1.0);
}

vec4 layers_color(ivec2 at, float coc) {
    const vec3 TINTS[8] = vec3[8](
        vec3(0.90, 0.20, 0.55), vec3(0.95, 0.35, 0.15), vec3(0.97, 0.65, 0.10),
        vec3(0.90, 0.90, 0.20), vec3(0.35, 0.85, 0.30), vec3(0.15, 0.75, 0.80),
        vec3(0.25, 0.45, 0.95), vec3(0.60, 0.35, 0.95));
    int layer = 0;
    for (int i = 0; i < 7; i++) layer += int(coc > layer_limits_px[i]);
    return vec4(TINTS[layer], 0.55);
}

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(at, textureSize(depth_tx, 0)))) return;
    imageStore(out_overlay_img, at, MODE(at, coc_at(at)));
}

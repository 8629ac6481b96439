// The source of a compact step: x -> (1 - c L_x) (1 - c L_y) x, a slight smoothing that ends where
// nothing flows and keeps all light (lib/compact.lib.glsl).
//
// Inputs
//   color_tx        rgb times coverage, a coverage
//   coc_tx          circle of confusion, diameter in pixels
// Output
//   out_color_img

#include "lib/compact.lib.glsl"

layout(local_size_x = 16, local_size_y = 16) in;

uniform sampler2D color_tx;
uniform sampler2D coc_tx;
uniform vec2 axis_scales;  // diameter along x, y / coc_tx
layout(rgba32f) uniform writeonly image2D out_color_img;

ivec2 size;

float diameter_at(ivec2 at) { return abs(texelFetch(coc_tx, at, 0).r); }
bool is_inside(ivec2 at) { return all(greaterThanEqual(at, ivec2(0))) && all(lessThan(at, size)); }

float weight(float d, ivec2 neighbour, float scale) {
    if (!is_inside(neighbour)) return 0.0;
    float narrower = min(d, diameter_at(neighbour)) * scale;
    return compact_at(narrower * narrower);
}

vec4 smoothed_down(ivec2 at) {
    const ivec2 down = ivec2(0, 1);
    float d = diameter_at(at);
    float before = weight(d, at - down, axis_scales.y), after = weight(d, at + down, axis_scales.y);
    vec4 x = texelFetch(color_tx, at, 0), sum = x;
    if (before > 0.0) sum += before * (texelFetch(color_tx, at - down, 0) - x);
    if (after > 0.0) sum += after * (texelFetch(color_tx, at + down, 0) - x);
    return sum;
}

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    size = textureSize(color_tx, 0);
    if (!is_inside(at)) return;
    const ivec2 across = ivec2(1, 0);
    float d = diameter_at(at);
    float before = weight(d, at - across, axis_scales.x), after = weight(d, at + across, axis_scales.x);
    vec4 x = smoothed_down(at), sum = x;
    if (before > 0.0) sum += before * (smoothed_down(at - across) - x);
    if (after > 0.0) sum += after * (smoothed_down(at + across) - x);
    imageStore(out_color_img, at, sum);
}

// Composites a blurred layer over the layers behind it. The blur makes coverage, like color, ripple slightly beyond
// 0..1. It is not clamped, because the two ripples cancel, so that a uniform color stays uniform.

uniform bool is_farthest;  // the layer covers everything, so its color can be divided by its blurred coverage

// Composites a pixel of the layer (rgb times coverage, a coverage) over the color behind it.
vec4 composite_over(vec4 layer, vec3 behind) {
    vec3 color = layer.rgb + (1.0 - layer.a) * behind;
    if (is_farthest) color = layer.a == 1.0 ? layer.rgb : layer.rgb / max(layer.a, 1e-3);
    return vec4(max(color, 0.0), 1.0);
}

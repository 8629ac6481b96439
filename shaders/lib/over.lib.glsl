// Composites a blurred layer over the layers behind it. Coverage, like colour, ripples slightly beyond 0..1;
// it is not clamped, because the two ripples cancel and a uniform colour stays uniform.

uniform bool is_farthest;  // the layer covers everything, so dividing by its blurred coverage is safe

// Composites a pixel of the layer (rgb times coverage, a coverage) over the colour behind it.
vec4 composite_over(vec4 layer, vec3 behind) {
    vec3 color = layer.rgb + (1.0 - layer.a) * behind;
    if (is_farthest) color = layer.a == 1.0 ? layer.rgb : layer.rgb / max(layer.a, 1e-3);
    return vec4(max(color, 0.0), 1.0);
}

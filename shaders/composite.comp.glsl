// A blurred layer over what is behind it. Coverage ripples a little beyond 0..1 as colour does; left
// as it is the two cancel, so that one colour everywhere stays that colour.
//
// Inputs
//   layer_tx        rgb times coverage, a coverage, both blurred
// Output
//   out_color_img   rgb so far (read and written); a 1

layout(local_size_x = 16, local_size_y = 16) in;

uniform sampler2D layer_tx;
uniform bool is_farthest;  // it covers everything, so its blurred coverage divides out
layout(rgba32f) uniform image2D out_color_img;

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(at, textureSize(layer_tx, 0)))) return;
    vec4 layer = texelFetch(layer_tx, at, 0);
    vec3 color;
    if (is_farthest) {
        color = layer.a == 1.0 ? layer.rgb : layer.rgb / max(layer.a, 1e-3);
    } else {
        color = layer.rgb + (1.0 - layer.a) * imageLoad(out_color_img, at).rgb;
    }
    imageStore(out_color_img, at, vec4(max(color, 0.0), 1.0));
}

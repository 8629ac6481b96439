// Mixes the picture whose far field is blurred in parts of the lens with the one blurred in layers alone. While the
// far field fades in, this keeps its start from jumping.
//
// Inputs
//   without_tx      rgb of the picture blurred in layers alone
//   growth          weight of the picture with the far field, 0 to 1
// In and out
//   out_color_img   rgb of the picture with the far field, then the mix; a is kept

layout(local_size_x = PIXEL_GROUP, local_size_y = PIXEL_GROUP) in;

uniform sampler2D without_tx;
uniform float growth;
layout(rgba32f) uniform image2D out_color_img;

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(at, imageSize(out_color_img)))) return;
    vec4 color = imageLoad(out_color_img, at);
    imageStore(out_color_img, at, vec4(mix(texelFetch(without_tx, at, 0).rgb, color.rgb, growth), color.a));
}

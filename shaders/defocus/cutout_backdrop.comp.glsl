// Composites a picture that was blurred on its own, with alpha, over its backdrop, which stays sharp.
//
// Input
//   backdrop_tx   rgb, a alpha, premultiplied
// In and out
//   color_img   rgb, a alpha, premultiplied: the blurred picture, then the same over the backdrop

layout(local_size_x = PIXEL_GROUP, local_size_y = PIXEL_GROUP) in;

uniform sampler2D backdrop_tx;
uniform bool is_opaque;  // the result is opaque: alpha is set to exactly 1
layout(rgba32f) uniform image2D color_img;

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(at, imageSize(color_img)))) return;
    vec4 color = imageLoad(color_img, at);
    color += (1.0 - color.a) * texelFetch(backdrop_tx, at, 0);
    imageStore(color_img, at, vec4(max(color.rgb, 0.0), is_opaque ? 1.0 : color.a));
}

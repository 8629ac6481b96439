// Copies a picture texel by texel, 32 bytes a pixel, to measure the memory bandwidth of this machine.
//
// Input
//   color_tx        rgba32f
// Output
//   out_color_img   the same

layout(local_size_x = PIXEL_GROUP, local_size_y = PIXEL_GROUP) in;

uniform sampler2D color_tx;
layout(rgba32f) uniform writeonly image2D out_color_img;

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(at, textureSize(color_tx, 0)))) return;
    imageStore(out_color_img, at, texelFetch(color_tx, at, 0));
}

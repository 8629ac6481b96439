// Copies a picture pixel by pixel, to measure the memory bandwidth of this machine. Each pixel moves 32 bytes: 16 are
// read and 16 are written.
//
// Input
//   color_tx        rgba, 32-bit floats
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

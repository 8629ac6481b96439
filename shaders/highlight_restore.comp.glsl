// Puts the highlights back where there were too many to draw; runs on no pixel otherwise.
//
// Input
//   high_tx    rgb what was taken out
// Output
//   low_img    what is diffused, read and written

layout(local_size_x = PIXEL_GROUP, local_size_y = PIXEL_GROUP) in;

uniform sampler2D high_tx;
layout(rgba32f) uniform image2D low_img;

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(at, textureSize(high_tx, 0)))) return;
    imageStore(low_img, at, imageLoad(low_img, at) + vec4(texelFetch(high_tx, at, 0).rgb, 0.0));
}

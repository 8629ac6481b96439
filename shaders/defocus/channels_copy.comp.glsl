// Copies some channels of one picture into another. It is used where each color is blurred separately: the results
// are put together channel by channel.
//
// Inputs
//   picture_tx        rgba
//   copied_channels   for each of the four channels: 1 to copy it, 0 to leave it
// In and out
//   out_color_img     rgba; the channels that are not copied stay

layout(local_size_x = PIXEL_GROUP, local_size_y = PIXEL_GROUP) in;

uniform sampler2D picture_tx;
uniform vec4 copied_channels;
layout(rgba32f) uniform image2D out_color_img;

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(at, imageSize(out_color_img)))) return;
    vec4 color = imageLoad(out_color_img, at), source = texelFetch(picture_tx, at, 0);
    imageStore(out_color_img, at, mix(color, source, greaterThan(copied_channels, vec4(0.5))));
}

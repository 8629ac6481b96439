// Copies the plate's alpha into a picture of its own, so that it can be defocused like color.
//
// Input
//   color_tx        the plate: a alpha
// Output
//   out_color_img   rgb the alpha, the same in all three channels; a 1

layout(local_size_x = PIXEL_GROUP, local_size_y = PIXEL_GROUP) in;

uniform sampler2D color_tx;
layout(rgba32f) uniform writeonly image2D out_color_img;

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(at, textureSize(color_tx, 0)))) return;
    imageStore(out_color_img, at, vec4(vec3(texelFetch(color_tx, at, 0).a), 1.0));
}

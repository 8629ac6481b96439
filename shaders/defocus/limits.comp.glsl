// Limits light to 0 and above, and alpha to 0..1. The ripple of a disc kernel goes slightly beyond both.
//
// In and out
//   color_img   rgb light, a alpha

layout(local_size_x = PIXEL_GROUP, local_size_y = PIXEL_GROUP) in;

uniform bool is_opaque;  // the picture is opaque: alpha is set to exactly 1
layout(rgba32f) uniform image2D color_img;

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(at, imageSize(color_img)))) return;
    vec4 color = imageLoad(color_img, at);
    float alpha = is_opaque ? 1.0 : clamp(color.a, 0.0, 1.0);
    imageStore(color_img, at, vec4(max(color.rgb, 0.0), alpha));
}

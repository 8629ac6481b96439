// Copies the defocused alpha (alpha_as_color.comp.glsl) into the alpha of the defocused picture.
//
// Input
//   alpha_tx        r defocused alpha
// In and out
//   color_img       a receives the alpha, limited to 0..1; rgb is kept

layout(local_size_x = PIXEL_GROUP, local_size_y = PIXEL_GROUP) in;

uniform sampler2D alpha_tx;
layout(rgba32f) uniform image2D color_img;

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(at, textureSize(alpha_tx, 0)))) return;
    float alpha = clamp(texelFetch(alpha_tx, at, 0).r, 0.0, 1.0);
    imageStore(color_img, at, vec4(imageLoad(color_img, at).rgb, alpha));
}

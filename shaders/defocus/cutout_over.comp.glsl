// Composites what a matte keeps from the blur over the layers behind it.
//
// Inputs
//   cutout_tx       rgb times its share of the pixel, a the share
//   cutout_alpha_tx the same with the plate's alpha as its light, used on top
//   cutout_coc_tx   the signed coc at its depth, pixels, by which it has its place among the layers
//   coc_tx          that of the picture without it
// Output
//   out_color_img   rgb so far (read and written); alpha stays, but on top

layout(local_size_x = PIXEL_GROUP, local_size_y = PIXEL_GROUP) in;

uniform sampler2D cutout_tx;
uniform sampler2D cutout_alpha_tx;
uniform sampler2D cutout_coc_tx;
uniform sampler2D coc_tx;
uniform vec2 ends_px;     // the range of coc that has its place here
uniform bool is_on_top;   // it must not lie behind the picture
layout(rgba32f) uniform image2D out_color_img;

#define MARGIN_PX 0.01

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(at, imageSize(out_color_img)))) return;
    vec4 kept = texelFetch(cutout_tx, at, 0), color = imageLoad(out_color_img, at);
    float coc = texelFetch(cutout_coc_tx, at, 0).r;
    if (coc < ends_px.x || coc >= ends_px.y || kept.a == 0.0) return;
    if (is_on_top && coc > texelFetch(coc_tx, at, 0).r + MARGIN_PX) return;
    float alpha = texelFetch(cutout_alpha_tx, at, 0).r + (1.0 - kept.a) * color.a;
    imageStore(out_color_img, at, vec4(kept.rgb + (1.0 - kept.a) * color.rgb, is_on_top ? alpha : color.a));
}

// Composites the part of a picture that a matte keeps sharp over the layers behind it.
//
// Inputs
//   cutout_tx       rgb times its share of the pixel, a the share
//   cutout_alpha_tx the same with the plate's alpha as its light, used on top
//   cutout_coc_tx   signed coc at its depth in pixels, which decides its layer
//   coc_tx          signed coc of the picture without it
// Output
//   out_color_img   rgb so far (read and written); alpha stays, but on top

layout(local_size_x = PIXEL_GROUP, local_size_y = PIXEL_GROUP) in;

uniform sampler2D cutout_tx;
uniform sampler2D cutout_alpha_tx;
uniform sampler2D cutout_coc_tx;
uniform sampler2D coc_tx;
uniform vec2 ends_px;     // the range of coc that is composited now
uniform bool is_on_top;   // composite all that is not behind the picture, and write alpha
layout(rgba32f) uniform image2D out_color_img;

#define MARGIN_PX 0.01  // difference in coc up to which the cutout is not behind the picture

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(at, imageSize(out_color_img)))) return;
    vec4 sharp = texelFetch(cutout_tx, at, 0), color = imageLoad(out_color_img, at);
    float coc = texelFetch(cutout_coc_tx, at, 0).r;
    if (coc < ends_px.x || coc >= ends_px.y || sharp.a == 0.0) return;
    if (is_on_top && coc > texelFetch(coc_tx, at, 0).r + MARGIN_PX) return;
    float alpha = texelFetch(cutout_alpha_tx, at, 0).r + (1.0 - sharp.a) * color.a;
    imageStore(out_color_img, at, vec4(sharp.rgb + (1.0 - sharp.a) * color.rgb, is_on_top ? alpha : color.a));
}

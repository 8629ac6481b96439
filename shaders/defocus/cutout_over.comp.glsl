// Composites the cutout, which is the part of a picture that a matte keeps sharp, over the layers behind it. The pass
// runs once for each layer, with the range of coc whose cutout pixels come next, or once on top of the finished
// picture.
//
// Inputs (coc: signed circle of confusion, diameter in pixels, negative in front of the focus)
//   cutout_tx       rgb of the cutout times its share of the pixel, a the share
//   cutout_alpha_tx r the plate's alpha in the cutout times the same share; used only on top
//   cutout_coc_tx   r coc at the depth of the cutout, which decides between which layers it lies
//   coc_tx          r coc of the picture without the cutout
// In and out
//   out_color_img   rgb of the picture so far, then with the cutout; a stays, except that on top it receives the alpha

layout(local_size_x = PIXEL_GROUP, local_size_y = PIXEL_GROUP) in;

uniform sampler2D cutout_tx;
uniform sampler2D cutout_alpha_tx;
uniform sampler2D cutout_coc_tx;
uniform sampler2D coc_tx;
uniform vec2 coc_range_px;  // only cutout pixels with a coc from x to below y are composited now
uniform bool is_on_top;     // composite all that is not behind the picture, and write alpha
layout(rgba32f) uniform image2D out_color_img;

#define MARGIN_PX 0.01  // difference in coc up to which the cutout is not behind the picture

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(at, imageSize(out_color_img)))) return;
    vec4 sharp = texelFetch(cutout_tx, at, 0), color = imageLoad(out_color_img, at);
    float coc = texelFetch(cutout_coc_tx, at, 0).r;
    if (coc < coc_range_px.x || coc >= coc_range_px.y || sharp.a == 0.0) return;
    if (is_on_top && coc > texelFetch(coc_tx, at, 0).r + MARGIN_PX) return;
    float alpha = texelFetch(cutout_alpha_tx, at, 0).r + (1.0 - sharp.a) * color.a;
    imageStore(out_color_img, at, vec4(sharp.rgb + (1.0 - sharp.a) * color.rgb, is_on_top ? alpha : color.a));
}

// Copies the circle of confusion (coc) of a plate that stores it in place of depth, and adds a constant shift: that
// of the focus of another color.
//
// Inputs
//   coc_tx       r signed coc: diameter in pixels, negative in front of the focus plane
//   shift_px     the shift, pixels of coc; 0 for a plain copy
// Output
//   out_coc_img  r coc_tx plus shift_px

layout(local_size_x = PIXEL_GROUP, local_size_y = PIXEL_GROUP) in;

uniform int first_row;  // first row of the band (render/defocus/pixel_list.py)
uniform sampler2D coc_tx;
uniform float shift_px;
layout(r32f) uniform writeonly image2D out_coc_img;

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy) + ivec2(0, first_row);
    if (any(greaterThanEqual(at, imageSize(out_coc_img)))) return;
    imageStore(out_coc_img, at, vec4(texelFetch(coc_tx, at, 0).r + shift_px));
}

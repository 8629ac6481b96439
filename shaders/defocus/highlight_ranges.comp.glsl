// Finds the range of the coc (signed circle of confusion, pixels) of the surfaces in 2 x 2 pixels, for the rays of
// lib/highlight_rays.lib.glsl. Nothing is written where no disc is drawn.
//
// Inputs
//   plan           the number of discs
//   coc_tx         r coc of the visible surface of each pixel
//   kind_tx        g coc of the nearest surface (lib/kind.lib.glsl)
// Output
//   out_ranges_img   r least, g greatest coc in the pixel, the next one across, and those below both

#include "lib/highlights.lib.glsl"  // Plan

layout(local_size_x = PIXEL_GROUP, local_size_y = PIXEL_GROUP) in;

uniform int first_row;  // first row of the band (render/defocus/pixel_list.py)
uniform sampler2D coc_tx;
uniform sampler2D kind_tx;
layout(rg32f) uniform writeonly image2D out_ranges_img;
layout(std430) readonly buffer plan_block { Plan plan; };

float least_of(vec4 v) { return min(min(v.x, v.y), min(v.z, v.w)); }

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy) + ivec2(0, first_row), size = imageSize(out_ranges_img);
    if (any(greaterThanEqual(at, size)) || plan.draw[1] == 0u) return;
    vec2 corner = vec2(at + 1) / vec2(size);
    vec4 cocs = textureGather(coc_tx, corner), nearest = textureGather(kind_tx, corner, 1);
    imageStore(out_ranges_img, at, vec4(least_of(min(cocs, nearest)), -least_of(-max(cocs, nearest)), 0.0, 0.0));
}

// Converts depth to the signed circle of confusion (coc), which is linear in 1 / depth.
//
// Input
//   depth_tx     r planar depth in meters, infinity where nothing was hit
// Output
//   out_coc_img  r diameter in pixels, negative in front of the focus plane, at most COC_MOST_PX either way

#include "lib/coc.lib.glsl"  // coc_of

layout(local_size_x = PIXEL_GROUP, local_size_y = PIXEL_GROUP) in;

uniform int first_row;  // first row of the band (render/defocus/pixel_list.py)
uniform sampler2D depth_tx;
layout(r32f) uniform writeonly image2D out_coc_img;

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy) + ivec2(0, first_row);
    if (any(greaterThanEqual(at, textureSize(depth_tx, 0)))) return;
    float coc_px = coc_of(texelFetch(depth_tx, at, 0).r, at);
    imageStore(out_coc_img, at, vec4(clamp(coc_px, -COC_MOST_PX, COC_MOST_PX)));
}

// Finds the rim: far pixels beside a nearer surface, whose colour anti-aliasing has mixed.
//
// Inputs
//   color_tx      scene-linear rgb
//   coc_tx        signed circle of confusion, diameter in pixels
// Outputs
//   out_rim_img   1 on the rim, else 0
//   out_far_img   rgb the pixel's own, a 0     (the rim is overwritten by
//   out_near_img  rgb 0, a own coc              fragments_split.comp.glsl)
//   pixel list    the rim

#define PIXEL_LIST_BINDING 0
#include "lib/pixel_list.lib.glsl"
#include "lib/silhouette.lib.glsl"

layout(local_size_x = 16, local_size_y = 16) in;

uniform sampler2D color_tx;
layout(r16f) uniform writeonly image2D out_rim_img;
layout(rgba32f) uniform writeonly image2D out_far_img;
layout(rgba32f) uniform writeonly image2D out_near_img;

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(at, textureSize(coc_tx, 0)))) return;
    float coc = coc_at(at);
    bool rim = false;
    for (int y = -1; y <= 1; ++y)
        for (int x = -1; x <= 1; ++x) rim = rim || is_in_front(coc_at(at + ivec2(x, y)), coc);
    if (rim) list_append(at);
    imageStore(out_rim_img, at, vec4(rim ? 1.0 : 0.0));
    imageStore(out_far_img, at, vec4(texelFetch(color_tx, at, 0).rgb, 0.0));
    imageStore(out_near_img, at, vec4(vec3(0.0), coc));
}

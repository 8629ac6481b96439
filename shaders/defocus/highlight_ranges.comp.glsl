// Prepares what the rays of lib/highlight_rays.lib.glsl meet: the range of the coc (signed circle of confusion, pixels)
// of the surfaces in 2 x 2 pixels, and the surfaces of edge pixels. Nothing is written where no disc is drawn.
//
// Inputs
//   plan           the number of discs
//   coc_tx         r coc of the visible surface of each pixel
//   kind_tx        r kind, g coc of the nearest surface (lib/kind.lib.glsl)
//   far_tx, near_tx   surfaces of edge pixels (unmix_far.comp.glsl): of far_tx a coverage of the near surface, of
//                  near_tx a its coc
// Outputs
//   out_ranges_img   r least, g greatest coc in the pixel, the next one across, and those below both
//   out_edges_img    r the pixel's word of lib/edge_word.lib.glsl

#include "lib/edge_word.lib.glsl"  // edge_word, LISTED_WORD
#include "lib/highlights.lib.glsl"  // Plan
#include "lib/kind.lib.glsl"  // FAR_EDGE, NEAR_EDGE, LISTED

layout(local_size_x = PIXEL_GROUP, local_size_y = PIXEL_GROUP) in;

uniform int first_row;  // first row of the band (render/defocus/pixel_list.py)
uniform sampler2D coc_tx;
uniform sampler2D kind_tx;
uniform sampler2D far_tx;
uniform sampler2D near_tx;
layout(rg32f) uniform writeonly image2D out_ranges_img;
layout(r32f) uniform writeonly image2D out_edges_img;
layout(std430) readonly buffer plan_block { Plan plan; };

float least_of(vec4 v) { return min(min(v.x, v.y), min(v.z, v.w)); }

float word_of(ivec2 at) {
    vec2 kind = texelFetch(kind_tx, at, 0).rg;
    float cover = texelFetch(far_tx, at, 0).a, behind = texelFetch(near_tx, at, 0).a;
    if (kind.r == FAR_EDGE) return edge_word(cover, kind.g, true);
    if (kind.r == NEAR_EDGE) return edge_word(cover, behind, false);
    return kind.r == LISTED ? uintBitsToFloat(LISTED_WORD) : edge_word(1.0, 0.0, false);
}

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy) + ivec2(0, first_row), size = imageSize(out_ranges_img);
    if (any(greaterThanEqual(at, size)) || plan.draw[1] == 0u) return;
    vec2 corner = vec2(at + 1) / vec2(size);
    vec4 cocs = textureGather(coc_tx, corner), nearest = textureGather(kind_tx, corner, 1);
    vec2 range = vec2(least_of(min(cocs, nearest)), -least_of(-max(cocs, nearest)));
    imageStore(out_ranges_img, at, vec4(range, 0.0, 0.0));
    imageStore(out_edges_img, at, vec4(word_of(at)));
}

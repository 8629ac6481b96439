// Finds the edges of surfaces behind the focus in front of surfaces with another blur, and their
// reach.
//
// Inputs
//   lib/far_fragments.lib.glsl
//   part_scale   diameter of a part of the lens over that of the lens
// Output
//   out_zone_img   for each block of FAR_BLOCK x FAR_BLOCK pixels the square of the reach in pixels, 0 or
//                  less for none: r of wide surfaces, g of surfaces so thin that layers are more accurate

#include "lib/far_fragments.lib.glsl"

layout(local_size_x = PIXEL_GROUP, local_size_y = PIXEL_GROUP) in;

uniform float part_scale;
uniform float nearest_px;   // least coc of both surfaces at an edge
uniform float thin_coc_px;  // a surface that is blurred more is not thin
layout(rg32f) uniform writeonly image2D out_zone_img;

#define LEAST_STEP_PX 1.8     // least difference in blur of an edge; less is right in one layer
#define LEAST_STEP_PART 0.585 // the same as a share of the disc of a part; the larger limit is used
#define MARGIN_PX 4.0         // added to the reach of an edge
#define WIDE_PX 5             // width in pixels from which a surface is wide
#define FULL_FROM 1.25        // multiple of a limit at which a zone has its whole reach

// Weight of a value that has passed a limit, 0 to 1. It is 0 at the limit: nothing appears suddenly
// while the lens or the focus moves.
float weight_past(float limit, float value) {
    return limit > 0.0 ? smoothstep(limit, FULL_FROM * limit, value) : 1.0;
}

// Weight of a difference in blur as a step between two surfaces, 0 to 1.
float step_between(float coc, float other, float least_step) {
    return weight_past(max(least_step, LEAST_STEP_PART * part_scale * max(coc, other)), abs(coc - other));
}

// 1 if the surface continues for WIDE_PX pixels, 0 if there is a step before.
float width_along(ivec2 at, ivec2 direction, float coc) {
    float wide = 1.0;
    for (int k = 1; k < WIDE_PX; ++k)
        wide = min(wide, 1.0 - step_between(coc, far_coc_at(at + k * direction), LEAST_STEP_PX / 2.0));
    return wide;
}

// Reach of the edge between a pixel and the next one: that of wide surfaces, and of thin ones.
vec2 reach_between(ivec2 at, float coc, ivec2 direction) {
    float other = far_coc_at(at + direction), nearest = min(coc, other);
    float reach = weight_past(nearest_px, nearest) * step_between(coc, other, LEAST_STEP_PX);
    if (nearest <= 0.0 || reach <= 0.0) return vec2(-1.0);
    reach *= max(coc, other) / 2.0 + MARGIN_PX;
    float thin = 1.0 - weight_past(thin_coc_px, nearest);
    if (thin > 0.0) thin *= 1.0 - min(width_along(at, -direction, coc), width_along(at + direction, direction, other));
    return reach * vec2(1.0 - thin, thin);
}

void main() {
    ivec2 block = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(block, imageSize(out_zone_img)))) return;
    vec2 reach = vec2(-1.0);
    for (int y = 0; y < FAR_BLOCK; ++y)
        for (int x = 0; x < FAR_BLOCK; ++x) {
            ivec2 at = block * FAR_BLOCK + ivec2(x, y);
            float coc = far_coc_at(at);
            if (coc <= 0.0) continue;
            reach = max(reach, reach_between(at, coc, ivec2(1, 0)));
            reach = max(reach, reach_between(at, coc, ivec2(0, 1)));
        }
    imageStore(out_zone_img, block, vec4(reach * abs(reach), 0.0, 0.0));
}

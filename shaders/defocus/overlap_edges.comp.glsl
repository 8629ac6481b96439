// Finds the edges between surfaces of different blur behind the focus, and how far each edge reaches.
//
// Behind the focus, the picture is computed in two ways: in layers, and as the mean of views through parts of the
// lens opening (part_view.comp.glsl). The mean of the views replaces the layers in zones around such edges
// (part_over.comp.glsl). This pass gives the edges, and overlap_zone.comp.glsl spreads them into zones.
//
// Inputs
//   lib/part_surfaces.lib.glsl   the surfaces behind the focus; coc is their diameter of blur in pixels
//   part_scale   diameter of a part of the lens over that of the whole lens
// Output
//   out_zone_img   for each block of FAR_BLOCK x FAR_BLOCK pixels the square of the reach in pixels, 0 or less if no
//                  edge is in the block: r reach of the edges of wide surfaces, g of edges of surfaces so thin that
//                  layers are more accurate there
//   out_seen_img   for each block r the share, 0 to 1, that shows surfaces behind the focus; 0 with ALL_DEPTHS

#include "lib/part_surfaces.lib.glsl"  // first_coc_at, least_px

layout(local_size_x = PIXEL_GROUP, local_size_y = PIXEL_GROUP) in;

uniform float part_scale;
uniform float nearest_px;   // least coc of both surfaces at an edge
uniform float thin_coc_px;  // a surface that is blurred more is not thin
layout(rg32f) uniform writeonly image2D out_zone_img;
layout(r32f) uniform writeonly image2D out_seen_img;

#define LEAST_STEP_PX 1.8       // least difference in blur of an edge; less is right in one layer
#define LEAST_STEP_SHARE 0.585  // the same as a share of the disc of a part; the larger limit is used
#define MARGIN_PX 4.0           // added to the reach of an edge
#define WIDE_PX 5               // width in pixels from which a surface is wide
#define FULL_FROM 1.25          // multiple of a limit at which a zone has its whole reach
// In front of the focus a surface is thin or wide by its width as a share of its coc: the views of a fence of thin
// wires show a pattern of separate wires (FLIP .0528 in layers, .0633 in views).
#define THIN_SHARE 0.4
#define WIDE_SHARE 0.8
#define WIDTH_MOST 40           // pixels; wider surfaces are not measured
#define FAR_TIMES 4.0           // multiple of least_px from which a surface is wholly behind the focus
#define SLOPE 0.1               // share of the coc by which it changes from pixel to pixel within a surface

// Weight, 0 to 1, of a value that has passed a limit. It is 0 at the limit itself and rises smoothly, so that no zone
// appears suddenly while the lens or the focus moves.
float weight_past(float limit, float value) {
    return limit > 0.0 ? smoothstep(limit, FULL_FROM * limit, value) : 1.0;
}

// Degree, 0 to 1, to which two neighbors with the coc `coc` and `other` belong to different surfaces.
float step_between(float coc, float other, float least_step) {
    return weight_past(max(least_step, LEAST_STEP_SHARE * part_scale * max(abs(coc), abs(other))), abs(coc - other));
}

// 1 if the surface at a pixel continues for WIDE_PX pixels along a direction, 0 if there is a step before that.
float width_along(ivec2 at, ivec2 direction, float coc) {
    float wide = 1.0;
    for (int k = 1; k < WIDE_PX; ++k)
        wide = min(wide, 1.0 - step_between(coc, first_coc_at(at + k * direction), LEAST_STEP_PX / 2.0));
    return wide;
}

#ifdef ALL_DEPTHS
// Width in pixels, up to WIDTH_MOST, of the surface at a pixel along a direction.
float width_px(ivec2 at, ivec2 direction, float coc) {
    float width = 1.0, inside = 1.0;
    for (int k = 1; k < WIDTH_MOST; ++k) {
        float step_px = abs(coc - first_coc_at(at + k * direction)), least_px = max(LEAST_STEP_PX / 2.0, SLOPE * abs(coc));
        inside *= 1.0 - weight_past(least_px, step_px);
        width += inside;
    }
    return width;
}

// Reach in pixels of the edge between a pixel and the next one along a direction, x for the edge of a wide surface in
// front of the focus; -1 if there is none.
vec2 reach_between(ivec2 at, float coc, ivec2 direction) {
    float other = first_coc_at(at + direction), nearest = min(coc, other);
    if (nearest >= 0.0) return vec2(-1.0);
    float reach = weight_past(nearest_px, -nearest) * step_between(coc, other, LEAST_STEP_PX);
    if (reach <= 0.0) return vec2(-1.0);
    float width = coc < other ? width_px(at, -direction, coc) : width_px(at + direction, direction, other);
    reach *= width >= float(WIDTH_MOST) - 0.5 ? 1.0 : smoothstep(THIN_SHARE, WIDE_SHARE, width / -nearest);
    return vec2(reach * (-nearest / 2.0 + MARGIN_PX), -1.0);
}
#else
// Reach in pixels of the edge between a pixel and the next one along a direction: x as the edge of a wide surface, y
// as that of a thin one; -1 if there is no edge.
vec2 reach_between(ivec2 at, float coc, ivec2 direction) {
    float other = first_coc_at(at + direction), nearest = min(coc, other);  // behind the focus the nearer coc is smaller
    float reach = weight_past(nearest_px, nearest) * step_between(coc, other, LEAST_STEP_PX);
    if (nearest <= 0.0 || reach <= 0.0) return vec2(-1.0);
    reach *= max(coc, other) / 2.0 + MARGIN_PX;
    float thin = 1.0 - weight_past(thin_coc_px, nearest);
    if (thin > 0.0) thin *= 1.0 - min(width_along(at, -direction, coc), width_along(at + direction, direction, other));
    return reach * vec2(1.0 - thin, thin);
}
#endif

void main() {
    ivec2 block = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(block, imageSize(out_zone_img)))) return;
    vec2 reach = vec2(-1.0);
    float seen = 0.0;
    for (int y = 0; y < FAR_BLOCK; ++y)
        for (int x = 0; x < FAR_BLOCK; ++x) {
            ivec2 at = block * FAR_BLOCK + ivec2(x, y);
            float coc = first_coc_at(at);
#ifndef ALL_DEPTHS
            if (coc <= 0.0) continue;
            seen += smoothstep(least_px, FAR_TIMES * least_px, coc);
#endif
            reach = max(reach, reach_between(at, coc, ivec2(1, 0)));
            reach = max(reach, reach_between(at, coc, ivec2(0, 1)));
        }
    imageStore(out_zone_img, block, vec4(reach * abs(reach), 0.0, 0.0));  // squared, but with its sign
    imageStore(out_seen_img, block, vec4(seen / float(FAR_BLOCK * FAR_BLOCK)));
}

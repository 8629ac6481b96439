// Spreads the edges of overlap_edges.comp.glsl into zones, along rows or along columns: each block receives the largest
// reach^2 - distance^2 of the edges around it. Because these are squares, one pass along the rows and then one along
// the columns give the exact result, with round zones.
//
// Inputs
//   zone_tx        for each block, in pixels^2, the squared reach of its edges, or that less the squared distance
//                  along the rows: r of wide surfaces, g of thin ones
//   axis           direction of the pass: (1, 0) along rows, (0, 1) along columns
//   reach_blocks   distance in blocks beyond which no edge reaches
// Output
//   out_zone_img   rg as in zone_tx, spread: above 0 in a zone (part_over.comp.glsl)

layout(local_size_x = PIXEL_GROUP, local_size_y = PIXEL_GROUP) in;

uniform sampler2D zone_tx;
uniform ivec2 axis;
uniform int reach_blocks;
layout(rg32f) uniform writeonly image2D out_zone_img;

void main() {
    ivec2 block = ivec2(gl_GlobalInvocationID.xy), last = textureSize(zone_tx, 0) - 1;
    if (any(greaterThan(block, last))) return;
    vec2 largest_reach = vec2(-1.0);
    for (int k = -reach_blocks; k <= reach_blocks; ++k) {
        ivec2 other = block + k * axis;
        if (any(lessThan(other, ivec2(0))) || any(greaterThan(other, last))) continue;
        float distance_px = float(k * FAR_BLOCK);
        largest_reach = max(largest_reach, texelFetch(zone_tx, other, 0).rg - distance_px * distance_px);
    }
    imageStore(out_zone_img, block, vec4(largest_reach, 0.0, 0.0));
}

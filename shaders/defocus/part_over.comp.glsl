// Replaces the layers behind the focus by the mean of the views through the parts of the lens, within zones that have
// soft edges.
//
// Inputs
//   sum_buf         sum over the parts (part_sum.comp.glsl): rgb times the known share, a the known share, which is the
//                   share of the light for which some view shows a surface
//   zone_tx         reach^2 - distance^2 in pixels^2 (overlap_zone.comp.glsl), above 0 in a zone, one texel for FAR_BLOCK x
//                   FAR_BLOCK pixels: r zones of wide surfaces, which are replaced, g zones of thin surfaces, in which
//                   the layers stay
// In and out
//   out_color_img   rgb of the layers, then with the zones replaced; a is kept

layout(local_size_x = PIXEL_GROUP, local_size_y = PIXEL_GROUP) in;

layout(std430) readonly buffer sum_block { vec4 sum_buf[]; };
uniform sampler2D zone_tx;
// Known share from which the views begin to be used, and from which they are used wholly.
uniform float known_from;
uniform float known_to;
layout(rgba32f) uniform image2D out_color_img;

// Share of a block that is in a zone, 0 to 1, from reach^2 - distance^2 of the edges around it.
float share_of(float excess_px_2) { return clamp(excess_px_2 / FAR_WHOLE_PX_2, 0.0, 1.0); }

// Weight of the views at a pixel, 0 to 1: the mean over the blocks around it, weighted by a tent that
// reaches two blocks to each side.
float zone_at(ivec2 at) {
    vec2 position = (vec2(at) + 0.5) / float(FAR_BLOCK) - 0.5;
    ivec2 low = ivec2(floor(position)) - 1, last = textureSize(zone_tx, 0) - 1;
    float zone_share = 0.0, weights = 0.0;
    for (int k = 0; k < 16; ++k) {
        ivec2 block = low + ivec2(k & 3, k >> 2);
        vec2 tent = max(2.0 - abs(vec2(block) - position), 0.0);
        vec2 zone = texelFetch(zone_tx, clamp(block, ivec2(0), last), 0).rg;
        zone_share += tent.x * tent.y * share_of(zone.r) * (1.0 - share_of(zone.g));
        weights += tent.x * tent.y;
    }
    return zone_share / weights;
}

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    ivec2 size = imageSize(out_color_img);
    if (any(greaterThanEqual(at, size))) return;
    vec4 sum = sum_buf[at.y * size.x + at.x], color = imageLoad(out_color_img, at);
    float known = clamp((sum.a - known_from) / (known_to - known_from), 0.0, 1.0), zone_share = zone_at(at) * known;
    vec3 light = max(sum.rgb / max(sum.a, 1e-3), 0.0);
    if (zone_share > 0.0) imageStore(out_color_img, at, vec4(mix(color.rgb, light, zone_share), color.a));
}

// Blurs by gathering: each pixel becomes the mean of the pixels inside the disc of its own circle of confusion (coc).
// A sample counts if its own disc reaches this pixel, so sharp foregrounds do not smear. What is behind this pixel counts
// with at least a share of this pixel's disc, because its light comes through the blur. A smaller disc is as much
// brighter as its area is smaller. Riguer et al. 2003, Scheuermann and Tatarchuk 2004.
//
// Every pixel of the disc is sampled: with fewer, a highlight's disc breaks up into dots. One dispatch takes some rows
// of the disc, for a band of the picture; sums are carried from one dispatch to the next.
//
// Inputs
//   color_tx     rgba
//   coc_tx       r signed coc: diameter in pixels, negative in front of the focus
// In and out
//   sum_img      rgba times weight, summed so far; after the last rows of the disc the blurred picture
//   weight_img   r sum of the weights so far; with SHAPED rgb, one sum for each color

#include "lib/aperture.lib.glsl"  // Cover, aperture_coverage, aperture_reach, is_one_pixel, times, most_of

layout(local_size_x = PIXEL_GROUP, local_size_y = PIXEL_GROUP) in;

uniform sampler2D color_tx;
uniform sampler2D coc_tx;
uniform int band_start;   // first row of the picture's band
uniform ivec2 disc_rows;  // first and last row of the disc in this dispatch, from its center
uniform bool is_first;  // the dispatch has the first rows of the disc: sums begin at 0
uniform bool is_last;   // the dispatch has the last rows: the sum is divided by the weights
layout(rgba32f) uniform image2D sum_img;
#ifdef SHAPED
layout(rgba32f) uniform image2D weight_img;
#else
layout(r32f) uniform image2D weight_img;
#endif

#define LEAST_WEIGHT 1e-6  // a smaller sum of weights counts as no sample
#define BEHIND_PX 0.5 // a coc larger by this much is behind, not on the same surface
#define BEHIND_SHARE 0.25 // least disc of a sample behind, as a share of this pixel's disc

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy) + ivec2(0, band_start), size = textureSize(color_tx, 0);
    if (any(greaterThanEqual(at, size))) return;
    float coc = texelFetch(coc_tx, at, 0).r, radius = 0.5 * coc;
    if (is_one_pixel(radius)) {
        if (is_last) imageStore(sum_img, at, texelFetch(color_tx, at, 0));
        return;
    }
    vec4 sum = is_first ? vec4(0.0) : imageLoad(sum_img, at);
#ifdef SHAPED
    Cover weight = is_first ? Cover(0.0) : imageLoad(weight_img, at).rgb;
#else
    Cover weight = is_first ? 0.0 : imageLoad(weight_img, at).r;
#endif
    // Half the size of the box around the disc, then its rows and columns in this dispatch that are in the picture.
    ivec2 reach = ivec2(min(ceil(aperture_reach(radius, DISC_RAMP_PX)), vec2(size)));
    ivec2 first = max(ivec2(-reach.x, max(-reach.y, disc_rows.x)), -at);
    ivec2 last = min(ivec2(reach.x, min(reach.y, disc_rows.y)), size - 1 - at);
    for (int y = first.y; y <= last.y; ++y)
        for (int x = first.x; x <= last.x; ++x) {
            vec2 offset = -vec2(x, y);  // offset from the center of the sample's disc to this pixel
            vec2 position = vec2(at + ivec2(x, y)) + 0.5;
#ifdef SHAPED
            float sample_coc = texelFetch(coc_tx, at + ivec2(x, y), 0).r;
            bool is_own = sample_coc < coc + BEHIND_PX;  // the sample's disc is used, upright behind the focus
            float signed_radius = is_own ? (sample_coc < 0.0 ? -1.0 : 1.0) * abs(radius) : radius;
            Cover inside = aperture_coverage(offset, signed_radius, DISC_RAMP_PX, position);
#else
            Cover inside = aperture_coverage(offset, radius, DISC_RAMP_PX, position);
            if (most_of(inside) <= 0.0) continue;
            float sample_coc = texelFetch(coc_tx, at + ivec2(x, y), 0).r;
#endif
            float least = sample_coc < coc + BEHIND_PX ? 1.0 : max(BEHIND_SHARE * abs(coc), 1.0);
            float disc = sample_coc < 0.0 ? min(sample_coc, -least) : max(sample_coc, least);
            inside = min(inside, aperture_coverage(offset, 0.5 * disc, DISC_RAMP_PX, position))
                * max(coc * coc / (disc * disc), 1.0);
            sum += times(inside, texelFetch(color_tx, at + ivec2(x, y), 0));
            weight += inside;
        }
#ifdef SHAPED
#ifdef IMAGED  // an opening can be dark in its middle, so that no sample counts
    if (is_last && most_of(weight) < LEAST_WEIGHT) {
        weight = Cover(1.0);
        sum = texelFetch(color_tx, at, 0);
    }
    weight = max(weight, LEAST_WEIGHT);
#endif
    if (is_last) sum /= vec4(weight, weight.g);
    imageStore(weight_img, at, vec4(weight, 0.0));
#else
    if (is_last) sum /= weight;
    imageStore(weight_img, at, vec4(weight));
#endif
    imageStore(sum_img, at, sum);
}

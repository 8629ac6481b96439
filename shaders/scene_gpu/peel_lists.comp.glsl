// Builds the fragment lists (lib/fragment_list.lib.glsl) for a band of rows of a scene's picture. Each fragment is a
// surface in a pixel, which lib/surface_groups.lib.glsl makes from samples, near to far.
//
// The shader is built twice. With COUNT it writes the length of each list. peel_starts.comp.glsl turns the lengths into
// starts. Then the build without COUNT writes the lists themselves.
//
// Inputs
//   samples        color and distance of the visible surface and of two behind it, several in each pixel, in the
//                  textures front_tx, first_tx, behind_tx and last_tx of lib/surface_groups.lib.glsl
//   depth_tx       planar depth of the picture, meters
//   first_row      first row of the band
//   end_row        the row after its last one
//   start_buf      without COUNT: twice the start of each pixel's list, plus 1 if it begins with the visible surface
// Output with COUNT
//   start_buf      twice the length of each pixel's list, plus 1 if it begins with the visible surface
// Outputs without COUNT
//   fragment_buf      three words a fragment (lib/fragment_words.lib.glsl)
//   out_position_img  position of the light in its pixel: r, g from the center in pixels, b the variance along an axis
//                     in pixels^2
//   out_color_img     rgb mean of the front samples; not written where only one surface is visible (is_done)
//   out_depth_img     meters; of the nearest fragment if the list begins with the visible surface

#include "lib/surface_groups.lib.glsl"  // GROUPS_MOST, Group, begin_pixel, group_within, front_count, is_done ...

layout(local_size_x = PIXEL_GROUP, local_size_y = PIXEL_GROUP) in;

uniform int first_row;
uniform int end_row;
uniform vec2 shifts[PEEL_DRAWS];  // shift of the samples in each draw, in distances between samples
uniform sampler2D depth_tx;

#ifdef COUNT
layout(std430) writeonly buffer start_block { uint start_buf[]; };
#else
layout(std430) readonly buffer start_block { uint start_buf[]; };
layout(std430) writeonly buffer fragment_block { uint fragment_buf[]; };
layout(rgba16f) uniform writeonly image2D out_color_img;
layout(r32f) uniform writeonly image2D out_depth_img;
layout(rgba16f) uniform writeonly image2D out_position_img;

// The position of the pixel's light as out_position_img has it: the mean and the variance of the samples' positions,
// weighted by their light, so that a lamp outweighs its surroundings. `light_sum` becomes the sum of the samples.
vec4 light_position(ivec2 pixel, out vec3 light_sum) {
    light_sum = vec3(0.0);
    if (is_done) return vec4(0.0, 0.0, 1.0 / 12.0, 1.0);
    vec2 sum = vec2(0.0);
    float squares = 0.0, weights = 1e-12;
    for (int i = 0; i < front_count; ++i) {
        vec3 light = front_sample(pixel, i).rgb;
        light_sum += light;
        float weight = (light.r + light.g + light.b) / 3.0;
        int number = i / PEEL_DRAWS;
        vec2 at = vec2(number % front_side, number / front_side) + 0.5 + shifts[i % PEEL_DRAWS];
        vec2 sample_position = at / float(front_side) - 0.5;
        sum += weight * sample_position;
        squares += weight * dot(sample_position, sample_position);
        weights += weight;
    }
    vec2 mean = sum / weights;
    float of_sample = 1.0 / (12.0 * float(front_count));
    return vec4(mean, 0.5 * max(squares / weights - dot(mean, mean), 0.0) + of_sample, 1.0);
}
#endif

#ifndef COUNT
void write_fragment(uint number, Group group) {
    uint at = 3u * number;
    vec3 light = min(group.color, 65504.0);
    fragment_buf[at] = packHalf2x16(light.rg);
    fragment_buf[at + 1u] = packHalf2x16(vec2(light.b, group.cover));
    fragment_buf[at + 2u] = floatBitsToUint(group.dioptres);
}
#endif

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy), at = pixel + ivec2(0, first_row);
    ivec2 size = textureSize(depth_tx, 0);
    if (at.x >= size.x || at.y >= end_row) return;
    uint index = uint(at.y * size.x + at.x), count = 0u;
    bool has_front = false, is_first = true;
    float depth_m = texelFetch(depth_tx, at, 0).r;
    begin_pixel(at, pixel, depth_m);
    int uncovered_count = front_count;  // front samples that no surface has taken yet
    float limit = 1e30;  // dioptres below which the next surface is
    float nearest = nearest_sample(pixel);  // its dioptres; negative if no sample is left
#ifndef COUNT
    uint start = start_buf[index] >> 1, list_capacity = (start_buf[index + 1u] >> 1) - start;
    vec3 light;
    imageStore(out_position_img, at, light_position(pixel, light));
    if (!is_done) imageStore(out_color_img, at, vec4(light / float(front_count), 1.0));
    imageStore(out_depth_img, at, vec4(depth_m));
    if (list_capacity == 0u) return;
    has_front = (start_buf[index] & 1u) == 1u;
#endif
    // one surface each round, from the nearest sample on; the last round takes all remaining samples
    for (int k = 0; k < GROUPS_MOST && nearest >= 0.0; ++k) {
        float low = k == GROUPS_MOST - 1 ? 0.0 : nearest / SAME_GROUP, next;  // dioptres
        Group group = group_within(pixel, low, limit, uncovered_count, next);
        limit = low;
        nearest = next;
        if (group.cover < LEAST_COVER) continue;
#ifdef COUNT
        // the list begins with the visible surfaces if the nearest one covers only a part of the pixel
        if (is_first) has_front = group.is_visible && group.cover < 1.0;
        if (has_front || !group.is_visible) ++count;
#else
        if (!has_front && group.is_visible) continue;  // the picture itself shows this surface
        if (count < list_capacity) write_fragment(start + count, group);
        if (has_front && is_first) imageStore(out_depth_img, at, vec4(1.0 / group.dioptres));
        ++count;
#endif
        is_first = false;
    }
#ifdef COUNT
    start_buf[index] = 2u * count + (has_front ? 1u : 0u);
#endif
}

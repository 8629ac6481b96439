// Builds the fragment lists for a band of a scene's picture (packed as in lib/fragment_list.lib.glsl).
// Compiled twice: COUNT writes the length of each list; WRITE, after peel_starts, the lists themselves.
//
// Inputs
//   lib/surface_groups.lib.glsl
//   depth_tx       metres of the picture
//   first_row      first row of the band
//   end_row        the row after its last one
// Output of COUNT
//   start_buf      twice the length of each pixel's list, plus 1 if it begins with the visible surface
// Input of WRITE   start_buf    Outputs
//   fragment_buf   three words a fragment
//   out_place_img  r, g position of the light in its pixel, from the centre, b the variance, pixels
//   out_color_img  the mean of the samples, where the pixel was not done
//   out_depth_img  metres; of the nearest fragment if the list begins with the visible surface

#include "lib/surface_groups.lib.glsl"

layout(local_size_x = PIXEL_GROUP, local_size_y = PIXEL_GROUP) in;

uniform int first_row;
uniform int end_row;
uniform vec2 shifts[PEEL_DRAWS];  // shift of each draw, in distances of samples
uniform sampler2D depth_tx;

#ifdef COUNT
layout(std430) writeonly buffer start_block { uint start_buf[]; };
#else
layout(std430) readonly buffer start_block { uint start_buf[]; };
layout(std430) writeonly buffer fragment_block { uint fragment_buf[]; };
layout(rgba16f) uniform writeonly image2D out_color_img;
layout(r32f) uniform writeonly image2D out_depth_img;
layout(rgba16f) uniform writeonly image2D out_place_img;

// The mean position of the pixel's light and its variance along an axis, weighted by luminance: a lamp outweighs its
// surroundings. Also adds up the light.
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
    begin_pixel(at, depth_m);
    int open_count = front_count;
    float limit = 1e30, nearest = nearest_sample(pixel);
#ifndef COUNT
    uint start = start_buf[index] >> 1, list_capacity = (start_buf[index + 1u] >> 1) - start;
    vec3 light;
    imageStore(out_place_img, at, light_position(pixel, light));
    if (!is_done) imageStore(out_color_img, at, vec4(light / float(front_count), 1.0));
    imageStore(out_depth_img, at, vec4(depth_m));
    if (list_capacity == 0u) return;
    has_front = (start_buf[index] & 1u) == 1u;
#endif
    for (int k = 0; k < GROUPS_MOST && nearest >= 0.0; ++k) {
        float low = k == GROUPS_MOST - 1 ? 0.0 : nearest / SAME_GROUP, next;
        Group group = group_within(pixel, low, limit, open_count, next);
        limit = low;
        nearest = next;
        if (group.cover < LEAST_COVER) continue;
#ifdef COUNT
        if (is_first) has_front = group.is_visible && group.cover < 1.0;
        if (has_front || !group.is_visible) ++count;
#else
        if (!has_front && group.is_visible) continue;
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

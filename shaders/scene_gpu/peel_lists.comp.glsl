// Makes the list of surfaces of each pixel in a band of rows of a scene's picture. Each fragment is a surface in the
// pixel, which lib/surface_groups.lib.glsl makes from samples, near to far. peel_starts.comp.glsl then finds where each
// list begins (lib/fragment_list.lib.glsl), and peel_pack.comp.glsl moves it there.
//
// Inputs
//   samples        color and distance of the visible surface and of two behind it, several in each pixel, in the
//                  textures front_tx, first_tx, behind_tx and last_tx of lib/surface_groups.lib.glsl
//   depth_tx       planar depth of the picture, meters
//   first_row      first row of the band
//   end_row        the row after its last one
// Outputs
//   start_buf         twice the length of each pixel's list, plus 1 if it begins with the visible surface
//   group_buf         PEEL_LIST_WORDS for each pixel of the band: the length of its list, and three words a fragment
//                     (lib/fragment_words.lib.glsl)
//   out_position_img  position of the light in its pixel: r, g from the center in pixels, b the variance along an axis
//                     in pixels^2
//   out_color_img     rgb mean of the front samples; not written where only one surface is visible (is_done)
//   out_depth_img     meters; of the nearest fragment if the list begins with the visible surface

#include "lib/surface_groups.lib.glsl"  // Group, begin_pixel, group_within, front_count, is_done ...
#include "lib/fragment_words.lib.glsl"  // fragment_words, WORDS

layout(local_size_x = PIXEL_GROUP, local_size_y = PIXEL_GROUP) in;

uniform int first_row;
uniform int end_row;
uniform vec2 shifts[PEEL_DRAWS];  // shift of the samples in each draw, in distances between samples
uniform sampler2D depth_tx;
layout(std430) writeonly buffer start_block { uint start_buf[]; };
layout(std430) writeonly buffer group_block { uint group_buf[]; };
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
        vec2 at = vec2(number % FRONT_SIDE, number / FRONT_SIDE) + 0.5 + shifts[i % PEEL_DRAWS];
        vec2 sample_position = at / float(FRONT_SIDE) - 0.5;
        sum += weight * sample_position;
        squares += weight * dot(sample_position, sample_position);
        weights += weight;
    }
    vec2 mean = sum / weights;
    float of_sample = 1.0 / (12.0 * float(front_count));
    return vec4(mean, 0.5 * max(squares / weights - dot(mean, mean), 0.0) + of_sample, 1.0);
}
void write_fragment(uint at, Group group) {
    uvec3 words = fragment_words(group.color, group.cover, group.dioptres);
    group_buf[at] = words.x;
    group_buf[at + 1u] = words.y;
    group_buf[at + 2u] = words.z;
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy), at = pixel + ivec2(0, first_row);
    ivec2 size = textureSize(depth_tx, 0);
    if (at.x >= size.x || at.y >= end_row) return;
    uint list = uint(PEEL_LIST_WORDS) * uint(pixel.y * size.x + pixel.x), count = 0u;
    bool has_front = false, is_first = true;
    float depth_m = texelFetch(depth_tx, at, 0).r;
    begin_pixel(at, pixel, depth_m);
    int uncovered_count = front_count;  // front samples that no surface has taken yet
    float limit = 1e30;  // dioptres below which the next surface is
    float nearest = nearest_sample(pixel);  // its dioptres; negative if no sample is left
    vec3 light;
    imageStore(out_position_img, at, light_position(pixel, light));
    if (!is_done) imageStore(out_color_img, at, vec4(light / float(front_count), 1.0));
    // one surface each round, from the nearest sample on; the last round takes all remaining samples
    for (int k = 0; k < PEEL_GROUPS && nearest >= 0.0; ++k) {
        float low = k == PEEL_GROUPS - 1 ? 0.0 : nearest / SAME_GROUP, next;  // dioptres
        Group group = group_within(pixel, low, limit, uncovered_count, next);
        limit = low;
        nearest = next;
        if (group.cover < LEAST_COVER) continue;
        // the list begins with the visible surfaces if the nearest one covers only a part of the pixel
        if (is_first) has_front = group.is_visible && group.cover < 1.0;
        if (is_first && has_front) depth_m = 1.0 / group.dioptres;
        is_first = false;
        if (group.is_visible && !has_front) continue;  // the picture itself shows this surface
        write_fragment(list + 1u + WORDS * count, group);
        ++count;
    }
    group_buf[list] = count;
    start_buf[at.y * size.x + at.x] = 2u * count + (has_front ? 1u : 0u);
    imageStore(out_depth_img, at, vec4(depth_m));
}

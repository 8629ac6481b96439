// Fragment lists of a band of a scene's picture (lib/fragment_list.lib.glsl tells how they are packed).
// Built twice: COUNT writes how long each list is, and WRITE, after peel_starts, the lists themselves.
//
// Inputs
//   lib/surface_groups.lib.glsl
//   color_tx       rgb of the whole picture
//   first_row      of the band
// Output of COUNT
//   start_buf      twice the length of each pixel's list, plus 1 where it begins with what is seen
// Input of WRITE   start_buf    Outputs
//   fragment_buf   three words a fragment
//   out_place_img  r, g where in each pixel its light stands, from the middle, b the variance, pixels
//   out_depth_img  metres of the nearest fragment, where the list begins with what is seen

#include "lib/surface_groups.lib.glsl"

layout(local_size_x = PIXEL_GROUP, local_size_y = PIXEL_GROUP) in;

uniform sampler2D color_tx;
uniform int first_row;
uniform int end_row;

#ifdef COUNT
layout(std430) writeonly buffer start_block { uint start_buf[]; };
#else
layout(std430) readonly buffer start_block { uint start_buf[]; };
layout(std430) writeonly buffer fragment_block { uint fragment_buf[]; };
layout(r32f) uniform writeonly image2D out_depth_img;
layout(rgba16f) uniform writeonly image2D out_place_img;

// The mean place of the pixel's light and its variance along an axis, by its luminance: a
// lamp counts, and hardly what is around it.
vec4 light_place(ivec2 pixel) {
    vec2 sum = vec2(0.0);
    float squares = 0.0, weights = 1e-12;
    for (int i = 0; i < FRONT_COUNT; ++i) {
        ivec2 sample_at = ivec2(i % front_side, i / front_side);
        vec3 light = texelFetch(front_tx, front_side * pixel + sample_at, 0).rgb;
        float weight = (light.r + light.g + light.b) / 3.0;
        vec2 place = (vec2(sample_at) + 0.5) / float(front_side) - 0.5;
        sum += weight * place;
        squares += weight * dot(place, place);
        weights += weight;
    }
    vec2 mean = sum / weights;
    float of_sample = 1.0 / (12.0 * float(front_side * front_side));
    return vec4(mean, 0.5 * max(squares / weights - dot(mean, mean), 0.0) + of_sample, 1.0);
}
#endif

#define RATIO_MOST 2.0

// The picture has more samples than the groups, which are brought to its light.
vec3 light_ratio(ivec2 at, ivec2 pixel) {
    vec3 sum = vec3(0.0);
    for (int i = 0; i < FRONT_COUNT; ++i)
        sum += texelFetch(front_tx, front_side * pixel + ivec2(i % front_side, i / front_side), 0).rgb;
    return (texelFetch(color_tx, at, 0).rgb * float(FRONT_COUNT) + 1e-4) / (sum + 1e-4);
}

#define COVER_STEP 0.13  // as far as the samples' cover of a straight edge may be from the truth

// Where two surfaces are seen, their colours and that of the picture tell the cover of the nearer one better
// than the samples, which stand in rows. Negative where it cannot be told; `ratio` is what is then left.
float told_cover(ivec2 at, ivec2 pixel, inout vec3 ratio) {
    Group seen[2];
    int left = FRONT_COUNT, count = 0;
    float limit = 1e30;
    for (int k = 0; k < GROUPS_MOST && left > 0; ++k) {
        float nearest = nearest_beyond(pixel, limit), low = k == GROUPS_MOST - 1 ? 0.0 : nearest / SAME_GROUP;
        Group group = group_within(pixel, low, limit, left);
        limit = low;
        if (!group.is_seen) continue;
        if (count == 2) return -1.0;
        seen[count++] = group;
    }
    if (count < 2) return -1.0;
    vec3 shown = texelFetch(color_tx, at, 0).rgb, step = seen[0].color - seen[1].color;
    float square = dot(step, step), light = max(dot(seen[0].color, seen[0].color), dot(seen[1].color, seen[1].color));
    if (square < 1e-3 * light + 1e-12) return -1.0;
    float cover = dot(shown - seen[1].color, step) / square;
    cover = clamp(cover, seen[0].cover - COVER_STEP, seen[0].cover + COVER_STEP);
    cover = clamp(cover, 1.0 / 64.0, 63.0 / 64.0);
    ratio = clamp((shown + 1e-4) / (mix(seen[1].color, seen[0].color, cover) + 1e-4), 1.0 / RATIO_MOST, RATIO_MOST);
    return cover;
}

// A light that these samples have missed, or met too often: the pixel stays as it is in the picture.
bool is_like(vec3 ratio) {
    return all(lessThan(ratio, vec3(RATIO_MOST))) && all(greaterThan(ratio, vec3(1.0 / RATIO_MOST)));
}

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
    ivec2 size = textureSize(color_tx, 0);
    if (at.x >= size.x || at.y >= end_row) return;
    uint index = uint(at.y * size.x + at.x), count = 0u;
    bool has_front = false;
    int left = FRONT_COUNT;
    float limit = 1e30;
    vec3 ratio = light_ratio(at, pixel);
#ifndef COUNT
    uint start = start_buf[index] >> 1, room = (start_buf[index + 1u] >> 1) - start;
    imageStore(out_place_img, at, light_place(pixel));
    if (room == 0u) return;
    has_front = (start_buf[index] & 1u) == 1u;
    float first_cover = has_front ? told_cover(at, pixel, ratio) : -1.0;
#endif
    for (int k = 0; k < GROUPS_MOST; ++k) {
        float nearest = nearest_beyond(pixel, limit);
        if (nearest < 0.0) break;
        float low = k == GROUPS_MOST - 1 ? 0.0 : nearest / SAME_GROUP;
        Group group = group_within(pixel, low, limit, left);
        limit = low;
        if (group.cover < LEAST_COVER) continue;
#ifdef COUNT
        if (k == 0) has_front = group.cover < 1.0 && is_like(ratio);
        if (has_front || !group.is_seen) ++count;
#else
        if (!has_front && group.is_seen) continue;
        if (has_front && group.is_seen) group.color *= ratio;
        if (k == 0 && first_cover > 0.0) group.cover = first_cover;
        if (count < room) write_fragment(start + count, group);
        if (k == 0) imageStore(out_depth_img, at, vec4(1.0 / group.dioptres));
        ++count;
#endif
    }
#ifdef COUNT
    start_buf[index] = 2u * count + (has_front ? 1u : 0u);
#endif
}

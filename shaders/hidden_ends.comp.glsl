// For each hidden pixel, along each direction: how far the nearest seen pixels are on both sides, and
// how much these two ends differ. A stripe that a wire breaks has alike ends along the stripe.
//
// Inputs
//   layer_tx       rgb times coverage, a coverage or HIDDEN
//   bits_buf       seen pixels (hidden_bits.comp.glsl)
//   pixel list     what is hidden
// Outputs (hidden pixels only)
//   out_ends_img   a direction a channel: steps ahead << 16 | steps back, 0 for none
//   out_cost_img   a direction a channel: mean squared difference of the ends, < 0 if not both exist

#define PIXEL_LIST_BINDING 0
#include "lib/hidden.lib.glsl"
#include "lib/pixel_list.lib.glsl"
#include "lib/tone.lib.glsl"

layout(local_size_x = PIXELS_PER_GROUP) in;

uniform sampler2D layer_tx;
layout(std430, binding = 1) buffer bits_block { uint bits_buf[]; };
layout(rgba32ui) uniform writeonly uimage2D out_ends_img;
layout(rgba32f) uniform writeonly image2D out_cost_img;

#define TAPS 2            // compare the ends and one pixel behind each,
#define TAP_WEIGHT 0.5    // which counts half

ivec2 size;

int steps_ahead(int k, int line, int i) {
    int per_line = words_per_line(k, size), base = first_word(k, size) + line * per_line;
    int word = i >> 5;
    uint bits = bits_buf[base + word] & (~0u << (i & 31));
    while (bits == 0u) {
        if (++word >= per_line) return 0;
        bits = bits_buf[base + word];
    }
    return word * 32 + findLSB(bits) - i;
}

int steps_back(int k, int line, int i) {
    int base = first_word(k, size) + line * words_per_line(k, size);
    int word = i >> 5;
    uint bits = bits_buf[base + word] & ((2u << (i & 31)) - 1u);
    while (bits == 0u) {
        if (--word < 0) return 0;
        bits = bits_buf[base + word];
    }
    return i - (word * 32 + findMSB(bits));
}

bool seen_at(ivec2 at, out vec4 toned_layer) {
    toned_layer = vec4(0.0);
    if (any(lessThan(at, ivec2(0))) || any(greaterThanEqual(at, size))) return false;
    vec4 layer = texelFetch(layer_tx, at, 0);
    if (layer.a < 0.0) return false;
    toned_layer = vec4(toned(layer.rgb / max(layer.a, 1e-4)) * layer.a, layer.a);
    return true;
}

float difference(ivec2 at, int k, int ahead, int back) {
    float sum = 0.0, weights = 0.0;
    for (int tap = 0; tap < TAPS; ++tap) {
        vec4 a, b;
        bool both = seen_at(at + (ahead + tap) * DIRECTION[k], a);
        both = seen_at(at - (back + tap) * DIRECTION[k], b) && both;
        if (!both) continue;
        float weight = tap == 0 ? 1.0 : TAP_WEIGHT;
        sum += weight * dot(a - b, a - b);
        weights += weight;
    }
    return sum / weights;
}

void main() {
    ivec2 at;
    if (!list_pixel(gl_GlobalInvocationID.x, at)) return;
    size = textureSize(layer_tx, 0);
    vec4 cost = vec4(-1.0);
    uvec4 ends = uvec4(0u);
    for (int k = 0; k < DIRECTIONS; ++k) {
        int line = line_of(k, at, size), i = position_of(k, at);
        int ahead = steps_ahead(k, line, i), back = steps_back(k, line, i);
        ends[k] = uint(ahead) << 16 | uint(back);
        if (ahead > 0 && back > 0) cost[k] = difference(at, k, ahead, back);
    }
    imageStore(out_ends_img, at, ends);
    imageStore(out_cost_img, at, cost);
}

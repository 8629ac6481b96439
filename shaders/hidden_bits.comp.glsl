// Packs which pixels of a layer are seen, 32 to a word, along each of the directions of
// lib/hidden.lib.glsl.
//
// Input
//   layer_tx   a coverage, HIDDEN where not seen
// Output
//   bits_buf

#include "lib/hidden.lib.glsl"

layout(local_size_x = 64) in;

uniform sampler2D layer_tx;
layout(std430, binding = 1) buffer bits_block { uint bits_buf[]; };

void main() {
    ivec2 size = textureSize(layer_tx, 0);
    int word = int(gl_GlobalInvocationID.x), k = int(gl_GlobalInvocationID.y);
    int per_line = words_per_line(k, size);
    if (word >= lines_of(k, size) * per_line) return;
    int line = word / per_line, start = word % per_line * 32;
    uint bits = 0u;
    for (int i = 0; i < 32; ++i) {
        ivec2 at = pixel_of(k, line, start + i, size);
        if (any(lessThan(at, ivec2(0))) || any(greaterThanEqual(at, size))) continue;
        if (texelFetch(layer_tx, at, 0).a >= 0.0) bits |= 1u << i;
    }
    bits_buf[first_word(k, size) + word] = bits;
}

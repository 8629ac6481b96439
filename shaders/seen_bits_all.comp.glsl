// The masks of lib/hidden.lib.glsl with every pixel seen of the tiles that a layer is worked on in.
//
// Output
//   bits_buf   32 pixels a word, along each direction; 0 beyond the picture's edge too

#include "lib/hidden.lib.glsl"
#define TILE_MASK_BINDING 2
#include "lib/tile_mask.lib.glsl"

layout(local_size_x = 64) in;

uniform ivec2 size;
layout(std430, binding = 1) writeonly buffer bits_block { uint bits_buf[]; };

void main() {
    int word = int(gl_GlobalInvocationID.x), k = int(gl_GlobalInvocationID.y);
    int per_line = words_per_line(k, size);
    if (word >= lines_of(k, size) * per_line) return;
    uint bits = 0u;
    for (int i = 0; i < 32; ++i) {
        ivec2 at = pixel_of(k, word / per_line, word % per_line * 32 + i, size);
        bool inside = all(greaterThanEqual(at, ivec2(0))) && all(lessThan(at, size));
        if (inside && is_active(at)) bits |= 1u << i;
    }
    bits_buf[first_word(k, size) + word] = bits;
}

// Sets the masks of lib/hidden.lib.glsl: every pixel of a layer's active tiles is visible.
//
// Output
//   bits_buf   32 pixels a word, along each direction; 0 beyond the picture's edge too

#include "lib/hidden.lib.glsl"
#include "lib/tile_mask.lib.glsl"

layout(local_size_x = WORD_GROUP) in;

uniform ivec2 size;
layout(std430) writeonly buffer bits_block { uint bits_buf[]; };

// Number of pixels from here on, along a direction, in the same tile and on the same side of the border.
int run_in_tile(ivec2 at, ivec2 direction) {
    ivec2 in_tile = at & (TILE - 1);
    int run = direction.y == 0 ? TILE : min(TILE - in_tile.y, size.y - at.y);
    if (direction.x > 0) run = min(run, min(TILE - in_tile.x, size.x - at.x));
    return direction.x < 0 ? min(run, in_tile.x + 1) : run;
}

void main() {
    int word = int(gl_GlobalInvocationID.x), k = int(gl_GlobalInvocationID.y);
    int per_line = words_per_line(k, size);
    if (word >= lines_of(k, size) * per_line) return;
    uint bits = 0u;
    for (int i = 0; i < 32;) {
        ivec2 at = pixel_of(k, word / per_line, word % per_line * 32 + i, size);
        bool inside = all(greaterThanEqual(at, ivec2(0))) && all(lessThan(at, size));
        int run = inside ? min(run_in_tile(at, DIRECTION[k]), 32 - i) : 1;
        if (inside && is_active(at)) bits |= (~0u >> (32 - run)) << i;
        i += run;
    }
    bits_buf[first_word(k, size) + word] = bits;
}

// Lists the hidden pixels to guess: one by one near visible pixels; deeper inside, one guess for each
// block of 2 x 2.
//
// Inputs
//   bits_buf     seen pixels (seen_bits_clear.comp.glsl)
//   pixel list   the hidden pixels
// Output
//   block list   hidden pixels, marked as lib/hidden_block.lib.glsl says

#include "lib/hidden_block.lib.glsl"
#include "lib/pixel_list.lib.glsl"
#include "lib/seen_bits.lib.glsl"

layout(local_size_x = PIXELS_PER_GROUP) in;

uniform ivec2 size;
uniform int slices;  // number of slices in which later passes work through the list
layout(std430) buffer block_list_block {
    uint block_groups[3];
    uint block_count;
    uint block_pixels[];  // y << 16 | x, see lib/pixel_list.lib.glsl
};

#define DEEP_PX 3  // farther than this from all visible pixels, along rows and columns, the guess is smooth

void append_block(ivec2 at, uint marks) {
    uint slot = atomicAdd(block_count, 1u);
    uint per_group = PIXELS_PER_GROUP * uint(slices);
    if (slot % per_group == 0u && slot / per_group < GROUPS_MAX) atomicAdd(block_groups[0], 1u);
    block_pixels[slot] = uint(at.y) << 16 | uint(at.x) | marks;
}

// True if no earlier pixel of the block is hidden.
bool is_first_of_block(ivec2 at) {
    ivec2 first = at & ~1, place = at - first;
    bool is_first = place.x == 0 || is_seen(ivec2(first.x, at.y), size);
    if (place.y == 1) is_first = is_first && is_seen(first, size) && is_seen_or_outside(first + ivec2(1, 0), size);
    return is_first;
}

bool is_hidden(ivec2 at) {
    at = clamp(at, ivec2(0), size - 1);
    return !is_seen(at, size);
}

bool is_deep(ivec2 first) {
    const int far = DEEP_PX + 1;
    bool is_whole = is_hidden(first) && is_hidden(first + ivec2(1, 0)) && is_hidden(first + ivec2(0, 1)) &&
        is_hidden(first + 1);
    return is_whole && is_hidden(first - ivec2(DEEP_PX, 0)) && is_hidden(first + ivec2(far, 0)) &&
        is_hidden(first - ivec2(0, DEEP_PX)) && is_hidden(first + ivec2(0, far));
}

void list_block(ivec2 at) {
    bool is_first = is_first_of_block(at), is_whole = is_deep(at & ~1);
    if (is_first || !is_whole)
        append_block(at, (is_first ? MARK_FIRST : 0u) | (is_whole ? MARK_WHOLE : 0u));
}

void main() { FOR_EACH_LISTED(list_block) }

// Two lists of pixels in one buffer, the first one from the first word on, the second one from the last word backwards.
// A later pass works on one kind of pixel at a time: a software rasterizer runs both sides of every branch. A word is
// y << 16 | x, perhaps with flags. The order of the words differs from run to run.

#include "lib/list_slice.lib.glsl"  // PIXELS_PER_GROUP, GROUPS_MAX, slice_start, slice_end

layout(std430) buffer two_lists_block {
    uint first_groups[3];   // workgroups (x, y, z) of a pass over the first list,
    uint first_count;
    uint second_groups[3];  // of one over the second,
    uint second_count;
    uint both_groups[3];    // and of one over both
    uint unused;
    uint listed_words[];
};

// Appends a word to the first list or to the second, and a workgroup of the later passes if the word is the first of a
// group. The later passes work in this many slices.
void append_word(bool is_first, uint word, int slices) {
    uint slot = is_first ? atomicAdd(first_count, 1u) : atomicAdd(second_count, 1u);
    uint per_group = PIXELS_PER_GROUP * uint(slices), last = uint(listed_words.length()) - 1u;
    bool opens_group = slot % per_group == 0u && slot / per_group < GROUPS_MAX / 2u;
    if (opens_group) atomicAdd(both_groups[0], 1u);
    if (opens_group && is_first) atomicAdd(first_groups[0], 1u);
    if (opens_group && !is_first) atomicAdd(second_groups[0], 1u);
    listed_words[is_first ? slot : last - slot] = word;
}

// A word by its number; the words of the second list follow those of the first.
uint word_at(uint slot) {
    return listed_words[slot < first_count ? slot : uint(listed_words.length()) - 1u - (slot - first_count)];
}

ivec2 pixel_of_word(uint word) { return ivec2(word & 0x7fffu, word >> 16 & 0x7fffu); }

// Loop over the slice of one list or of both, in the main of a later pass; DO is a function of the word.
#define FOR_EACH_OF(START, COUNT, DO) \
    uint count = COUNT, slot = slice_start(count) + gl_GlobalInvocationID.x; \
    if (slot >= slice_end(count)) return; \
    do DO(word_at(START + slot)); while ((slot += gl_NumWorkGroups.x * PIXELS_PER_GROUP) < slice_end(count));
#define FOR_EACH_IN_FIRST(DO) FOR_EACH_OF(0u, first_count, DO)
#define FOR_EACH_IN_SECOND(DO) FOR_EACH_OF(first_count, second_count, DO)
#define FOR_EACH_IN_BOTH(DO) FOR_EACH_OF(0u, first_count + second_count, DO)

// Two lists of pixels in one buffer: one (front) from the first word on, the other (back) from the last word backwards.
// In this way neighboring invocations of a later pass do the same kind of work, see lib/pixel_list.lib.glsl. A word is
// y << 16 | x, perhaps with flags. The order of the words differs from run to run.

#include "lib/list_slice.lib.glsl"

layout(std430) buffer two_lists_block {
    uint front_groups[3];  // workgroups (x, y, z) of a pass over the front list,
    uint front_count;
    uint back_groups[3];   // of one over the back,
    uint back_count;
    uint both_groups[3];   // and of one over both
    uint unused;
    uint listed_words[];
};

// Appends a word to one of the lists, and a workgroup of the later passes if the word is the first of a group. `parts`
// is the number of slices in which the later passes work.
void append_word(bool is_front, uint word, int parts) {
    uint slot = is_front ? atomicAdd(front_count, 1u) : atomicAdd(back_count, 1u);
    uint per_group = PIXELS_PER_GROUP * uint(parts), last = uint(listed_words.length()) - 1u;
    bool opens_group = slot % per_group == 0u && slot / per_group < GROUPS_MAX / 2u;
    if (opens_group) atomicAdd(both_groups[0], 1u);
    if (opens_group && is_front) atomicAdd(front_groups[0], 1u);
    if (opens_group && !is_front) atomicAdd(back_groups[0], 1u);
    listed_words[is_front ? slot : last - slot] = word;
}

// A word by its number: first the front list, then the back list.
uint word_at(uint slot) {
    return listed_words[slot < front_count ? slot : uint(listed_words.length()) - 1u - (slot - front_count)];
}

ivec2 pixel_of_word(uint word) { return ivec2(word & 0x7fffu, word >> 16 & 0x7fffu); }

// Loop over the slice of one list or of both, in the main of a later pass; DO is a function of the word.
#define FOR_EACH_OF(FIRST, COUNT, DO) \
    uint count = COUNT, slot = slice_start(count) + gl_GlobalInvocationID.x; \
    if (slot >= slice_end(count)) return; \
    do DO(word_at(FIRST + slot)); while ((slot += gl_NumWorkGroups.x * PIXELS_PER_GROUP) < slice_end(count));
#define FOR_EACH_IN_FRONT(DO) FOR_EACH_OF(0u, front_count, DO)
#define FOR_EACH_IN_BACK(DO) FOR_EACH_OF(front_count, back_count, DO)
#define FOR_EACH_IN_BOTH(DO) FOR_EACH_OF(0u, front_count + back_count, DO)

// A list of pixels that need more work, so that a later pass runs on these alone. The cost is then
// proportional to the list, even on a software rasterizer, which runs both sides of every branch.
//
// The first three words are the numbers of workgroups of the later pass (glDispatchComputeIndirect). The order of the
// pixels differs from run to run, so the work on one pixel must not depend on another.

#include "lib/list_slice.lib.glsl"  // PIXELS_PER_GROUP, GROUPS_MAX, slice_start, slice_end

layout(std430) buffer pixel_list_block {
    uint list_groups[3];
    uint list_count;
    uint list_pixels[];  // y << 16 | x
};

// Appends a pixel, and a workgroup of the later pass if the pixel is the first of a group.
void list_append(ivec2 at) {
    uint slot = atomicAdd(list_count, 1u);
    bool opens_group = slot % PIXELS_PER_GROUP == 0u && slot / PIXELS_PER_GROUP < GROUPS_MAX;
    if (opens_group) atomicAdd(list_groups[0], 1u);
    list_pixels[slot] = uint(at.y) << 16 | uint(at.x);
}

ivec2 list_pixel(uint slot) {
    return ivec2(list_pixels[slot] & 0xffffu, list_pixels[slot] >> 16);
}

// Loops over the slice of the list, in the main of a later pass; DO is a function of the pixel's position.
#define FOR_EACH_LISTED(DO) \
    uint slot = slice_start(list_count) + gl_GlobalInvocationID.x; \
    if (slot >= slice_end(list_count)) return; \
    do DO(list_pixel(slot)); while ((slot += gl_NumWorkGroups.x * PIXELS_PER_GROUP) < slice_end(list_count));

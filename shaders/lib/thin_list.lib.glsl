// The list of rims that may be those of hair, for fragments_thin.comp.glsl: as lib/pixel_list.lib.glsl.

layout(std430) buffer thin_list_block {
    uint thin_groups[3];
    uint thin_count;
    uint thin_pixels[];  // y << 16 | x
};

void append_thin(ivec2 at) {
    uint slot = atomicAdd(thin_count, 1u);
    bool opens_group = slot % PIXELS_PER_GROUP == 0u && slot / PIXELS_PER_GROUP < GROUPS_MAX;
    if (opens_group) atomicAdd(thin_groups[0], 1u);
    thin_pixels[slot] = uint(at.y) << 16 | uint(at.x);
}

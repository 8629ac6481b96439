// Chooses the level at which highlights are merged, which limits the cost of drawing, and the
// position in the list at which each row of blocks writes its own, in the order of the picture. One
// workgroup.
//
// Input
//   plan      the sums of highlight_sprites.comp.glsl, COUNT
// Output
//   plan      the rest
// Read and written
//   row_buf   for the chosen level: sprites of each row of blocks; then of all rows before it

#include "lib/highlights.lib.glsl"

#define WORKERS 256
layout(local_size_x = WORKERS) in;

layout(std430) buffer plan_block { Plan plan; };
layout(std430) buffer row_block { uint row_buf[]; };

uniform ivec2 blocks;           // across, down
uniform uint sprites_max;
uniform uint restore_groups_x;  // workgroups of highlight_restore, unless all highlights are drawn
uniform uint restore_groups_y;

shared uint sprites_sh[WORKERS];
shared int level_sh;

bool is_too_much(int level) { return plan.sprites[level] > sprites_max || (plan.too_large >> level & 1u) != 0u; }

void choose_level() {
    int level = 0;
    while (level < HIGHLIGHT_LEVELS && is_too_much(level)) ++level;
    level_sh = min(level, HIGHLIGHT_LEVELS - 1);
    plan.draw = uint[4](4u, level < HIGHLIGHT_LEVELS ? plan.sprites[level_sh] : 0u, 0u, 0u);
    plan.level = uint(level);
    bool are_all_drawn = level < HIGHLIGHT_LEVELS - 1;  // true if no block is put back into the diffusion
    plan.restore_groups = uint[3](are_all_drawn ? 0u : restore_groups_x, are_all_drawn ? 0u : restore_groups_y, 1u);
}

void main() {
    int worker = int(gl_LocalInvocationID.x), each = (blocks.y + WORKERS - 1) / WORKERS;
    int first = min(worker * each, blocks.y), last = min(first + each, blocks.y);
    if (worker == 0) choose_level();
    barrier();
    uint sprites = 0u;
    for (int row = first; row < last; ++row) sprites += row_buf[row_of(level_sh, row, blocks)];
    sprites_sh[worker] = sprites;
    barrier();
    uint sprites_before = 0u;
    for (int i = 0; i < worker; ++i) sprites_before += sprites_sh[i];
    for (int row = first; row < last; ++row) {
        uint row_sprites = row_buf[row_of(level_sh, row, blocks)];
        row_buf[row_of(level_sh, row, blocks)] = sprites_before;
        sprites_before += row_sprites;
    }
}

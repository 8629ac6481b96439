// Chooses the level at which highlights are merged, which limits the cost of drawing, and the position in the list of
// sprites at which each row of blocks writes its own, so that they follow the order of the picture. A sprite is a disc
// that is drawn for merged highlights (lib/highlights.lib.glsl). Runs as one workgroup, whose invocations take equal
// numbers of rows.
//
// Inputs
//   sprites_max   largest number of sprites to draw
//   small_sprites_max   the same if together they are small
// In and out
//   plan      before: the sums of highlight_sprites.comp.glsl, built with COUNT; after: also the level, the draw call
//             and the workgroups of highlight_restore.comp.glsl
//   row_buf   for the chosen level, before: number of sprites of each row of blocks; after: of all rows before it

#include "lib/highlights.lib.glsl"  // Plan, row_index

#define WORKERS 256
layout(local_size_x = WORKERS) in;

layout(std430) buffer plan_block { Plan plan; };
layout(std430) buffer row_block { uint row_buf[]; };

uniform ivec2 blocks;           // across, down
uniform uint sprites_max, small_sprites_max;
uniform uint restore_groups_x;  // workgroups of highlight_restore, unless all highlights are drawn
uniform uint restore_groups_y;

shared uint sprites_sh[WORKERS];  // number of sprites in the rows of each invocation
shared int level_sh;              // the chosen level

// Sprites are small if they need no more than this part of the area that may be drawn.
#define SMALL_AREA (AREA_UNITS / 16u)

// True if a level has too many sprites, or too large an area to draw.
bool is_too_much(int level) {
    uint most = plan.area[level] <= SMALL_AREA ? small_sprites_max : sprites_max;
    return plan.sprites[level] > most || (plan.too_large >> level & 1u) != 0u;
}

// Chooses the first level that is not too much, and writes it into the plan.
void choose_level() {
    int level = 0;
    while (level < HIGHLIGHT_LEVELS && is_too_much(level)) ++level;
    // level is HIGHLIGHT_LEVELS if even the last list is too long; nothing is drawn then.
    level_sh = min(level, HIGHLIGHT_LEVELS - 1);
    plan.draw[0] = 4u;
    plan.draw[1] = level < HIGHLIGHT_LEVELS ? plan.sprites[level_sh] : 0u;
    plan.draw[2] = plan.draw[3] = 0u;
    plan.level = uint(level);
    bool are_all_drawn = level < HIGHLIGHT_LEVELS - 1;  // true if no block is put back into the diffusion
    plan.restore_groups[0] = are_all_drawn ? 0u : restore_groups_x;
    plan.restore_groups[1] = are_all_drawn ? 0u : restore_groups_y;
    plan.restore_groups[2] = 1u;
}

void main() {
    // each: rows of blocks for each invocation.
    int worker = int(gl_LocalInvocationID.x), each = (blocks.y + WORKERS - 1) / WORKERS;
    int first = min(worker * each, blocks.y), last = min(first + each, blocks.y);
    if (worker == 0) choose_level();
    barrier();
    uint sprites = 0u;
    // The sums of each invocation's rows, then of all rows before them.
    for (int row = first; row < last; ++row) sprites += row_buf[row_index(level_sh, row, blocks)];
    sprites_sh[worker] = sprites;
    barrier();
    uint sprites_before = 0u;
    for (int i = 0; i < worker; ++i) sprites_before += sprites_sh[i];
    for (int row = first; row < last; ++row) {
        uint row_sprites = row_buf[row_index(level_sh, row, blocks)];
        row_buf[row_index(level_sh, row, blocks)] = sprites_before;
        sprites_before += row_sprites;
    }
}

// Chooses how far highlights are merged, and where each block writes its own. One workgroup adds up
// the tallies, so that drawing has a bounded cost and the list is deterministic.
//
// Input
//   tally_buf    highlight_sprites.comp.glsl, COUNT
// Outputs
//   plan, offset_buf

#include "lib/highlights.lib.glsl"

#define WORKERS 256
layout(local_size_x = WORKERS) in;

layout(std430) readonly buffer tally_block { BlockTally tally_buf[]; };
layout(std430) writeonly buffer plan_block { Plan plan; };
layout(std430) writeonly buffer offset_block { uint offset_buf[]; };

uniform int block_count;
uniform uint sprites_max;
uniform float area_max;         // largest area to draw, pixels
uniform uint restore_groups_x;  // workgroups of highlight_restore, unless all highlights are drawn
uniform uint restore_groups_y;

shared uint sprites_sh[WORKERS][LEVELS];
shared float area_sh[WORKERS][LEVELS];
shared int level_sh;

void main() {
    int worker = int(gl_LocalInvocationID.x);
    int each = (block_count + WORKERS - 1) / WORKERS;
    int first = min(worker * each, block_count), last = min(first + each, block_count);
    for (int level = 0; level < LEVELS; ++level) {
        uint sprites = 0u;
        float area = 0.0;
        for (int i = first; i < last; ++i) {
            sprites += tally_buf[i].sprites[level];
            area += tally_buf[i].area[level];
        }
        sprites_sh[worker][level] = sprites;
        area_sh[worker][level] = area;
    }
    barrier();
    if (worker == 0) {
        int level = 0;
        uint drawn_sprites = 0u;
        for (; level < LEVELS; ++level) {
            uint sprites = 0u;
            float area = 0.0;
            for (int i = 0; i < WORKERS; ++i) {
                sprites += sprites_sh[i][level];
                area += area_sh[i][level];
            }
            if (sprites > sprites_max || area > area_max) continue;
            drawn_sprites = sprites;
            break;
        }
        plan.draw = uint[4](4u, drawn_sprites, 0u, 0u);
        plan.level = uint(level);
        bool whole = level < LEVELS - 1;  // no block is returned to the diffusion
        plan.restore_groups = uint[3](whole ? 0u : restore_groups_x, whole ? 0u : restore_groups_y, 1u);
        level_sh = min(level, LEVELS - 1);
    }
    barrier();
    uint offset = 0u;
    for (int i = 0; i < worker; ++i) offset += sprites_sh[i][level_sh];
    for (int i = first; i < last; ++i) {
        offset_buf[i] = offset;
        offset += tally_buf[i].sprites[level_sh];
    }
}

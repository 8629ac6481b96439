// Lists the blocks of 8 x 8 pixels with highlights, one block an invocation, and empties all sums.
//
// Input
//   high_tx      rgb of the removed light (highlight_split.comp.glsl)
// Outputs
//   pixel list   the blocks with highlights, across and down
//   tally_buf, row_buf   of blocks without highlights, and of rows of blocks: 0
//   plan         its sums: 0

#include "lib/highlights.lib.glsl"
#include "lib/pixel_list.lib.glsl"

layout(local_size_x = HIGHLIGHT_GROUP, local_size_y = HIGHLIGHT_GROUP) in;

uniform int first_row;  // first row of the band (defocus/pixel_list.py)
uniform sampler2D high_tx;
layout(std430) writeonly buffer tally_block { uint tally_buf[]; };
layout(std430) writeonly buffer row_block { uint row_buf[]; };
layout(std430) writeonly buffer plan_block { Plan plan; };

void empty_sums(ivec2 block, ivec2 blocks) {
    for (int level = 0; level < HIGHLIGHT_LEVELS; ++level) {
        row_buf[row_of(level, block.y, blocks)] = 0u;
        if (block.y > 0) continue;
        plan.sprites[level] = 0u;
        plan.area[level] = 0u;
    }
    if (block.y == 0) plan.too_large = 0u;
}

void main() {
    ivec2 block = ivec2(gl_GlobalInvocationID.xy) + ivec2(0, first_row), size = textureSize(high_tx, 0);
    ivec2 blocks = (size + HIGHLIGHT_BLOCK - 1) / HIGHLIGHT_BLOCK;
    if (any(greaterThanEqual(block, blocks))) return;
    if (block.x == 0) empty_sums(block, blocks);
    ivec2 first = block * HIGHLIGHT_BLOCK, end = min(first + HIGHLIGHT_BLOCK, size);
    vec3 light = vec3(0.0);
    for (int y = first.y; y < end.y; ++y)
        for (int x = first.x; x < end.x; ++x) light += texelFetch(high_tx, ivec2(x, y), 0).rgb;
    if (any(greaterThan(light, vec3(0.0)))) {
        list_append(block);
        return;
    }
    for (int level = 0; level < HIGHLIGHT_LEVELS; ++level) tally_buf[tally_of(level, block, blocks)] = 0u;
}

// Lists the blocks of 8 x 8 pixels with highlights, one block an invocation. The tallies of others are zero.
//
// Input
//   high_tx      rgb of the removed light (highlight_split.comp.glsl)
// Outputs
//   pixel list   the blocks with highlights, across and down
//   tally_buf    a tally a block, for blocks without highlights

#include "lib/highlights.lib.glsl"
#include "lib/pixel_list.lib.glsl"

layout(local_size_x = HIGHLIGHT_GROUP, local_size_y = HIGHLIGHT_GROUP) in;

uniform int first_row;  // first row of the band (gpu/pixel_bands.py)
uniform sampler2D high_tx;
layout(std430) writeonly buffer tally_block { BlockTally tally_buf[]; };

void main() {
    ivec2 block = ivec2(gl_GlobalInvocationID.xy) + ivec2(0, first_row), size = textureSize(high_tx, 0);
    ivec2 blocks = (size + HIGHLIGHT_BLOCK - 1) / HIGHLIGHT_BLOCK;
    if (any(greaterThanEqual(block, blocks))) return;
    ivec2 first = block * HIGHLIGHT_BLOCK, end = min(first + HIGHLIGHT_BLOCK, size);
    vec3 light = vec3(0.0);
    for (int y = first.y; y < end.y; ++y)
        for (int x = first.x; x < end.x; ++x) light += texelFetch(high_tx, ivec2(x, y), 0).rgb;
    if (any(greaterThan(light, vec3(0.0)))) {
        list_append(block);
        return;
    }
    BlockTally none;
    for (int level = 0; level < LEVELS; ++level) {
        none.sprites[level] = 0u;
        none.area[level] = 0.0;
    }
    tally_buf[block.y * blocks.x + block.x] = none;
}

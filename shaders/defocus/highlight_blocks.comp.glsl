// Lists the blocks of 8 x 8 pixels that contain highlights, one block an invocation, and sets all sums of the next
// pass (highlight_sprites.comp.glsl) to 0.
//
// Words (lib/highlights.lib.glsl): a sprite is a disc that is drawn for one or several highlights of similar coc
// (signed circle of confusion); a higher level merges more of them; the plan has the number of sprites of each level,
// and says which level is drawn.
//
// Input
//   lit_buf      bits of the pixels with a highlight (highlight_split.comp.glsl)
// Outputs
//   pixel list   the blocks with highlights; x and y count blocks across and down
//   tally_buf    number of sprites of each block at each level: 0 for blocks without highlights, others stay
//   row_buf      the same for each row of blocks: 0
//   plan         0 in its sums

#include "lib/highlights.lib.glsl"  // Plan, tally_index, row_index
#include "lib/lit_bits.lib.glsl"  // lit_word, lit_buf
#include "lib/pixel_list.lib.glsl"  // list_append

layout(local_size_x = HIGHLIGHT_GROUP, local_size_y = HIGHLIGHT_GROUP) in;

uniform int first_row;  // first row of the band (render/defocus/pixel_list.py)
uniform ivec2 picture_size;
layout(std430) writeonly buffer tally_block { uint tally_buf[]; };
layout(std430) writeonly buffer row_block { uint row_buf[]; };
layout(std430) writeonly buffer plan_block { Plan plan; };

// Clears the sums of a row of blocks; the first row clears those of the plan too.
void empty_sums(ivec2 block, ivec2 blocks) {
    for (int level = 0; level < HIGHLIGHT_LEVELS; ++level) {
        row_buf[row_index(level, block.y, blocks)] = 0u;
        if (block.y > 0) continue;
        plan.sprites[level] = 0u;
        plan.area[level] = 0u;
    }
    if (block.y == 0) plan.too_large = 0u;
}

void main() {
    ivec2 block = ivec2(gl_GlobalInvocationID.xy) + ivec2(0, first_row);
    ivec2 blocks = (picture_size + HIGHLIGHT_BLOCK - 1) / HIGHLIGHT_BLOCK;
    if (any(greaterThanEqual(block, blocks))) return;
    if (block.x == 0) empty_sums(block, blocks);
    int word = lit_word(block * HIGHLIGHT_BLOCK, picture_size);
    if ((lit_buf[word] | lit_buf[word + 1]) != 0u) {
        list_append(block);
        return;
    }
    for (int level = 0; level < HIGHLIGHT_LEVELS; ++level) tally_buf[tally_index(level, block, blocks)] = 0u;
}

// The list of highlights. Pixels of similar coc are merged in blocks of up to 8 x 8, larger discs more
// than small ones, at several levels; the first level whose list is short enough is drawn. The last two
// levels merge whole blocks, except on bright surfaces: the first of them merges these as the level
// before it, and the last one leaves them to the diffusion.

const float MERGE_SHARE[HIGHLIGHT_LEVELS] = float[](0.0625, 0.125, 0.25, 1.0e9, 1.0e9);  // block side / disc diameter
const float SURFACE_SHARE = 0.25;  // the same on bright surfaces, where wider discs would show as spots

struct Sprite {
    vec4 place;  // centre x, y in pixels; signed coc; half the width of the rim's ramp, pixels
    vec4 light;  // rgb of a pixel wholly inside the disc
};

#define AREA_PARTS 0x100000u  // the largest area to draw, in the unit in which areas are counted

struct Plan {
    uint draw[4];            // vertices, instances, first vertex, base instance
    uint level;              // HIGHLIGHT_LEVELS: even the last list is too long, nothing is drawn
    uint restore_groups[3];  // workgroups of highlight_restore: none if all is drawn
    uint sprites[HIGHLIGHT_LEVELS];  // number of sprites of the whole picture, by level
    uint area[HIGHLIGHT_LEVELS];     // area to draw, by level; AREA_PARTS is the largest allowed
    uint too_large;                  // bit l is set if level l has a larger area
};

// The indices of a block and of a row of blocks in their buffers of sprite numbers.
int tally_of(int level, ivec2 block, ivec2 blocks) { return (level * blocks.y + block.y) * blocks.x + block.x; }
int row_of(int level, int row, ivec2 blocks) { return level * blocks.y + row; }

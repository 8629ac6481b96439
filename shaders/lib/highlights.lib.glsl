// The list of highlights. Pixels of similar coc are merged in blocks of up to 8 x 8, larger discs more
// than small ones, at several levels; the first level whose list is short enough is drawn. The last
// level merges whole blocks, except on bright surfaces, which it leaves to the diffusion.

#define LEVELS 4
const float MERGE_SHARE[LEVELS] = float[](0.0625, 0.125, 0.25, 1.0e9);  // block side / disc diameter

struct Sprite {
    vec4 place;  // centre x, y in pixels; signed coc; half the width of the rim's ramp, pixels
    vec4 light;  // rgb of a pixel wholly inside the disc
};

struct BlockTally {
    uvec4 sprites;  // a level each
    vec4 area;      // pixels to draw, a level each
};

struct Plan {
    uint draw[4];            // vertices, instances, first vertex, base instance
    uint level;              // LEVELS: even the last list is too long, nothing is drawn
    uint restore_groups[3];  // workgroups of highlight_restore: none if all is drawn
};

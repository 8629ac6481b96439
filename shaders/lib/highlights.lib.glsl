// The list of highlights. Pixels of similar coc are merged in blocks of up to 8 x 8, larger discs more
// than small ones, at several levels; the first level whose list is short enough is drawn. The last two
// levels merge whole blocks, except on bright surfaces: the first of them merges these as the level
// before it, and the last one leaves them to the diffusion.

#define LEVELS 5
const float MERGE_SHARE[LEVELS] = float[](0.0625, 0.125, 0.25, 1.0e9, 1.0e9);  // block side / disc diameter
const float SURFACE_SHARE = 0.25;  // the same on bright surfaces, where wider discs would show as spots

struct Sprite {
    vec4 place;  // centre x, y in pixels; signed coc; half the width of the rim's ramp, pixels
    vec4 light;  // rgb of a pixel wholly inside the disc
};

struct BlockTally {
    uint sprites[LEVELS];
    float area[LEVELS];  // pixels to draw
};

struct Plan {
    uint draw[4];            // vertices, instances, first vertex, base instance
    uint level;              // LEVELS: even the last list is too long, nothing is drawn
    uint restore_groups[3];  // workgroups of highlight_restore: none if all is drawn
};

// The list of highlights to draw. Each entry is a sprite: a disc that stands for one or more pixels.
//
// Pixels of similar circle of confusion (coc) are merged within blocks of up to 8 x 8, more pixels for larger discs.
// This is done at several levels, which merge more and more. The first level whose list is short enough is drawn.
// The last two levels merge whole blocks, except on bright surfaces (lib/highlight_limit.lib.glsl): the first of the
// two merges these like the level before it, and the last one leaves them to the diffusion.

const float MERGE_SHARE[HIGHLIGHT_LEVELS] = float[](0.0625, 0.125, 0.25, 1.0e9, 1.0e9);  // block side / disc diameter
const float SURFACE_SHARE = 0.25;  // the same on bright surfaces, where wider discs would show as spots

struct Sprite {
    vec4 disc;   // x, y position of the center; z signed coc; w half the width of the soft rim; all in pixels
    vec4 light;  // rgb of a pixel wholly inside the disc; a least signed coc that a ray from the lens may meet
    vec4 nodes;  // where rays are traced (lib/highlight_nodes.lib.glsl)
};

// In place of the number of nodes in a row.
#define NOT_HIDDEN 0.0    // nothing is near enough to hide the highlight
#define ALL_HIDDEN -1.0   // it is not drawn
#define LARGE_DISC -2.0   // rays are traced where it is drawn

// A surface nearer by less than MARGIN_PX, or less than MARGIN_SHARE of the highlight's coc, belongs to the highlight.
#define MARGIN_PX 2.0
#define MARGIN_SHARE 0.1
float margin_of(float coc) { return max(MARGIN_PX, MARGIN_SHARE * abs(coc)); }

// Up to a coc of SHARP_PX a nearer fragment covers just its own pixel; from BLURRED_PX on, compositing
// its blurred layer does the hiding.
#define SHARP_PX 1.0
#define BLURRED_PX 4.0

#define AREA_UNITS 0x100000u  // the largest area that may be drawn, in the unit in which areas are counted

// What is drawn, and the sums from which this is decided.
struct Plan {
    uint draw[4];            // arguments of an indirect draw: vertices, instances, first vertex, base instance
    uint level;              // level that is drawn; HIGHLIGHT_LEVELS: even the last list is too long, nothing is
    uint restore_groups[3];  // workgroups of highlight_restore: none if all is drawn
    uint sprites[HIGHLIGHT_LEVELS];  // number of sprites of the whole picture, by level
    uint area[HIGHLIGHT_LEVELS];     // area to draw, by level; AREA_UNITS is the largest allowed
    uint too_large;                  // bit l is set if the area of level l is larger than allowed
};

// The index of a block in tally_buf, and of a row of blocks in row_buf; both hold numbers of sprites.
int tally_index(int level, ivec2 block, ivec2 blocks) { return (level * blocks.y + block.y) * blocks.x + block.x; }
int row_index(int level, int row, ivec2 blocks) { return level * blocks.y + row; }

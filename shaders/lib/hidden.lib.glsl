// Numbers the pixels of a layer along four directions, to find the visible pixels nearest to a hidden one. A pixel is
// hidden where almost only nearer layers are visible.
//
// A pixel has one bit in a mask for each direction, which is set if the pixel is visible. The bits of a line are packed
// 32 to a word, so that one read skips 32 hidden pixels. The directions, and the line and position of the pixel (x, y)
// in a layer of width w and height h:
//
//   0 across     (1, 0)    line y          position x
//   1 down       (0, 1)    line x          position y
//   2 down right (1, 1)    line x - y + h  position y
//   3 down left  (-1, 1)   line x + y      position y

// A hidden pixel is marked by its alpha, which is -1 minus an encoding of its coverage, 0..1, and of its known share,
// 0..1. The known share counts in steps of 1 / KNOWN_STEPS; each step subtracts 4, so that the two do not overlap.
#define KNOWN_STEPS 256.0

float hidden_mark(float cover, float known) { return -1.0 - cover - 4.0 * floor(known * KNOWN_STEPS); }
float marked_known(float alpha) { return floor((-1.0 - alpha) / 4.0) / KNOWN_STEPS; }
float marked_cover(float alpha) { return -1.0 - alpha - 4.0 * KNOWN_STEPS * marked_known(alpha); }

// Least word of the mask of a layer's tiles (lib/tile_mask.lib.glsl) for a tile that may have hidden pixels; 1 for others.
#define TILE_WITH_HIDDEN 2u

#define NO_COST (-1.0)  // cost of a direction (hidden_cost.comp.glsl) that has no two ends; others are above -0.5
#define NO_WORD 0xffffu  // in place of the number of a word of a line

const ivec2 DIRECTION[HIDDEN_DIRECTIONS] = ivec2[](ivec2(1, 0), ivec2(0, 1), ivec2(1, 1), ivec2(-1, 1));

// The functions below take the number k of a direction and the size of the layer.
int line_of(int k, ivec2 at, ivec2 size) {
    return k == 0 ? at.y : k == 1 ? at.x : k == 2 ? at.x - at.y + size.y : at.x + at.y;
}

int position_of(int k, ivec2 at) { return k == 0 ? at.x : at.y; }

ivec2 pixel_of(int k, int line, int position, ivec2 size) {
    if (k == 0) return ivec2(position, line);
    int x = k == 1 ? line : k == 2 ? line + position - size.y : line - position;
    return ivec2(x, position);
}

// Number of words of a line.
int words_per_line(int k, ivec2 size) { return ((k == 0 ? size.x : size.y) + 31) / 32; }

// Number of lines.
int lines_of(int k, ivec2 size) { return k == 0 ? size.y : k == 1 ? size.x : size.x + size.y; }

// First word of a direction; the directions follow each other in one buffer.
int first_word(int k, ivec2 size) {
    int word = 0;
    for (int j = 0; j < k; ++j) word += lines_of(j, size) * words_per_line(j, size);
    return word;
}

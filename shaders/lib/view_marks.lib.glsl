// Marks of the tiles of the view through a part of the lens; a word is 0 until the mark is set.

layout(std430) buffer mark_block { uint mark_buf[]; };
uniform ivec2 tiles;  // across and down

// The two marks of a tile.
#define IS_BLURRED 0  // it has discs large enough to be seen
#define HAS_FRONT 1   // something in front of the focus is seen in it

int mark_word(ivec2 tile, int mark) { return 2 * (tile.y * tiles.x + tile.x) + mark; }
bool is_marked(ivec2 tile, int mark) { return mark_buf[mark_word(tile, mark)] != 0u; }
void set_mark(ivec2 tile, int mark) { mark_buf[mark_word(tile, mark)] = 1u; }

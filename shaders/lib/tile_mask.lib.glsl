// Mask of the active tiles of a picture: a word for each tile of TILE x TILE pixels, row by row. It is 0 if there is
// nothing to do in the tile; such tiles are neither read nor written.

layout(std430) readonly buffer tile_mask_block { uint tile_mask_buf[]; };
uniform int tiles_across;  // tiles across the whole picture

uint tile_word(ivec2 tile) { return tile_mask_buf[tile.y * tiles_across + tile.x]; }
bool is_tile_active(ivec2 tile) { return tile_word(tile) != 0u; }
bool is_active(ivec2 at) { return is_tile_active(at / TILE); }

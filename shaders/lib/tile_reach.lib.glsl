// Numbers the tiles of all layers for the passes that find the active ones, and says how far to look from each tile.
//
// A layer may be processed at a smaller size than the picture, and each layer can occur in two sizes, hence
// 2 * LAYERS_MAX entries. A tile of a smaller layer stands for several tiles of the picture. The z of an invocation is
// the number of its entry, whose words begin at `z * tile_words` in each buffer.

#define FAR_AWAY 65535  // in place of a distance in tiles: there is none within reach
#define TILE_GROUPS_MAX 65535u  // what OpenGL promises; longer lists are walked in strides

// x, y tiles across and down; z how many tiles away content still has an effect; w side of a pixel of the layer, in
// pixels of the picture.
uniform ivec4 layer_tiles[2 * LAYERS_MAX];
uniform int layer_number[2 * LAYERS_MAX];  // number of the layer, equal for its two sizes
uniform ivec2 picture_tiles;  // tiles of the picture across, down
uniform int tile_words;  // words of each entry in a buffer
uniform int list_words;  // words of the list of a layer's tiles (lib/tile_list.lib.glsl)
layout(std430) buffer tile_list_block { uint tile_list_buf[]; };

struct LayerTile {
    int entry;        // number of the entry
    ivec2 at, count;  // position of the tile; tiles of the layer across and down
    int reach, reduction;  // z and w of layer_tiles
};

// The tile of this invocation.
LayerTile layer_tile() {
    int entry = int(gl_GlobalInvocationID.z);
    ivec4 tiles = layer_tiles[entry];
    return LayerTile(entry, ivec2(gl_GlobalInvocationID.xy), tiles.xy, tiles.z, tiles.w);
}

// Index of a tile at another position of the same layer, in a buffer with a word for each tile of each entry.
int tile_index(LayerTile tile, ivec2 at) { return tile.entry * tile_words + at.y * tile.count.x + at.x; }

// Index of a tile of the picture in hole_buf, which has a word for each tile of the picture and each entry: the
// distance to the next hole, a tile in which the layer is open (lib/tile_content.lib.glsl).
int hole_index(int entry, ivec2 at) { return entry * tile_words + at.y * picture_tiles.x + at.x; }

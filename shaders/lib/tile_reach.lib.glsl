// Tiles of all layers, and how far to look from each. The z of an invocation is its layer, whose tiles
// begin at `z * tile_words` in each buffer.

#define FAR_AWAY 65535
#define TILE_GROUPS_MAX 65535u  // what OpenGL promises; longer lists are walked in strides

uniform ivec4 layer_tiles[2 * LAYERS_MAX];  // tiles across and down; tiles beyond which content has no effect;
                                        // size of a pixel of the layer, in pixels of the picture
uniform int layer_number[2 * LAYERS_MAX];  // equal for two sizes of the same layer
uniform ivec2 picture_tiles;  // across, down
uniform int tile_words;
uniform int list_words;  // words of the list of a layer's tiles (lib/tile_list.lib.glsl)
layout(std430) buffer tile_list_block { uint tile_list_buf[]; };

struct LayerTile {
    int layer;
    ivec2 at, count;  // tiles across and down
    int reach, reduction;
};

LayerTile layer_tile() {
    int layer = int(gl_GlobalInvocationID.z);
    ivec4 tiles = layer_tiles[layer];
    return LayerTile(layer, ivec2(gl_GlobalInvocationID.xy), tiles.xy, tiles.z, tiles.w);
}

int word_of(LayerTile tile, ivec2 at) { return tile.layer * tile_words + at.y * tile.count.x + at.x; }

// The word of a layer for a tile of the picture.
int hole_word(int layer, ivec2 at) { return layer * tile_words + at.y * picture_tiles.x + at.x; }

// Measures two distances along rows of tiles: from each tile of a layer to the next tile with content, and from each
// tile of the picture to the next hole, which is a tile in which the layer is open (lib/tile_content.lib.glsl). Also
// empties the lists of tiles. An invocation handles one tile of one layer.
//
// A layer processed at 1/2, 1/4 or 1/8 size has fewer tiles: each stands for several tiles of the picture.
//
// Inputs
//   content_buf    word of each tile of the picture (tile_layers.comp.glsl)
//   coc_range_tx   r least signed coc in each tile of the picture (circle of confusion, diameter in pixels)
// Outputs
//   distance_buf   for each tile of each layer the number of tiles to the next with content; FAR_AWAY for none
//   hole_buf       for each layer and tile of the picture the number of tiles to the next hole; FAR_AWAY for none
//   hider_buf      for each tile of each layer the least signed coc in the tile, in pixels of the picture
//   tile lists     heads of lists without tiles (lib/tile_list.lib.glsl)

#include "lib/tile_content.lib.glsl"  // is_layer_open
#include "lib/tile_reach.lib.glsl"  // FAR_AWAY, LayerTile, layer_tile, tile_index, hole_index, layer_number ...

layout(local_size_x = TILE_GROUP, local_size_y = TILE_GROUP) in;

uniform int hole_reach;  // tiles of the picture beyond which a hole has no effect
layout(std430) readonly buffer content_block { uint content_buf[]; };
uniform sampler2D coc_range_tx;
layout(std430) writeonly buffer distance_block { int distance_buf[]; };
layout(std430) writeonly buffer hole_block { int hole_buf[]; };
layout(std430) writeonly buffer hider_block { float hider_buf[]; };

// True if the layer has content in its tile `at`.
bool has_content(LayerTile tile, ivec2 at) {
    uint content = 0u;
    ivec2 first = at * tile.reduction, end = min(first + tile.reduction, picture_tiles);
    for (int y = first.y; y < end.y; ++y)
        for (int x = first.x; x < end.x; ++x) content |= content_buf[y * picture_tiles.x + x];
    return has_content(content, layer_number[tile.entry]);
}

// The word of a tile of the picture; 0 beyond the ends of the row.
uint word_at(ivec2 at) {
    return at.x < 0 || at.x >= picture_tiles.x ? 0u : content_buf[at.y * picture_tiles.x + at.x];
}

// Writes the distance to the next tile of the row in which the layer is open.
void find_hole(LayerTile tile) {
    int distance = FAR_AWAY, step = 0, layer = layer_number[tile.entry];
    do {
        uint words = word_at(tile.at - ivec2(step, 0)) | word_at(tile.at + ivec2(step, 0));
        if (is_layer_open(words, layer)) distance = step;
    } while (++step <= hole_reach && distance == FAR_AWAY);
    hole_buf[hole_index(tile.entry, tile.at)] = distance;
}

// The least signed coc in a tile of a layer, from the tiles of the picture for which it stands.
float nearest_in(LayerTile tile) {
    float nearest = 1e30;
    ivec2 first = tile.at * tile.reduction, end = min(first + tile.reduction, picture_tiles);
    for (int y = first.y; y < end.y; ++y)
        for (int x = first.x; x < end.x; ++x) nearest = min(nearest, texelFetch(coc_range_tx, ivec2(x, y), 0).r);
    return nearest;
}

// Writes the head of an empty list: no workgroups and no tiles. In the pass over the picture, a tile has `reduction` x
// `reduction` workgroups.
void empty_list(LayerTile tile) {
    int first = tile.entry * list_words;
    for (int i = 0; i < TILE_LIST_HEAD; ++i) tile_list_buf[first + i] = 0u;
    tile_list_buf[first + 1] = tile_list_buf[first + 2] = 1u;
    tile_list_buf[first + 4] = tile_list_buf[first + 5] = uint(tile.reduction);
}

void main() {
    LayerTile tile = layer_tile();
    if (any(greaterThanEqual(tile.at, picture_tiles))) return;
    find_hole(tile);
    if (any(greaterThanEqual(tile.at, tile.count))) return;
    if (tile.at == ivec2(0)) empty_list(tile);
    int distance = FAR_AWAY;
    for (int step = 0; step <= tile.reach && distance == FAR_AWAY; ++step) {
        bool before = tile.at.x - step >= 0 && has_content(tile, tile.at - ivec2(step, 0));
        bool after = tile.at.x + step < tile.count.x && has_content(tile, tile.at + ivec2(step, 0));
        if (before || after) distance = step;
    }
    distance_buf[tile_index(tile, tile.at)] = distance;
    hider_buf[tile_index(tile, tile.at)] = nearest_in(tile);
}

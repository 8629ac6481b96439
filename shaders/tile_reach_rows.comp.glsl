// Measures the distance of each tile of each layer, along its row, to the next one with content, and to the
// next one where a nearer layer can uncover it; and empties the lists of tiles.
//
// A tile of a layer processed at 1/2, 1/4 or 1/8 size stands for several tiles of the picture.
//
// Inputs
//   content_buf, nearest_buf   of the picture's tiles (tile_layers.comp.glsl)
// Outputs (one of each a tile of each layer)
//   distance_buf   tiles along the row to the next with content, and << 16 to the next that is uncovered;
//                  FAR_AWAY: there is none
//   hider_buf      least signed coc in the tile, pixels of the picture
//   tile lists     without tiles (lib/tile_list.lib.glsl)

#include "lib/tile_content.lib.glsl"
#include "lib/tile_reach.lib.glsl"

layout(local_size_x = TILE_GROUP, local_size_y = TILE_GROUP) in;

uniform ivec2 picture_tiles;  // across, down
layout(std430) readonly buffer content_block { uint content_buf[]; };
layout(std430) readonly buffer nearest_block { float nearest_buf[]; };
layout(std430) writeonly buffer distance_block { uint distance_buf[]; };
layout(std430) writeonly buffer hider_block { float hider_buf[]; };

// The words of all tiles of the picture in a tile of the layer, and `beside` it to the right and below.
uint word_at(LayerTile tile, ivec2 at, int beside) {
    uint word = 0u;
    ivec2 first = at * tile.reduction, end = min(first + tile.reduction + beside, picture_tiles);
    for (int y = first.y; y < end.y; ++y)
        for (int x = first.x; x < end.x; ++x) word |= content_buf[y * picture_tiles.x + x];
    return word;
}

// Whether a tile has content of its layer, and whether that is uncovered there: a silhouette may lie between
// two tiles.
bvec2 found_at(LayerTile tile, ivec2 at) {
    if (at.x < 0 || at.x >= tile.count.x) return bvec2(false);
    return bvec2(has_content(word_at(tile, at, 0), tile.layer), is_uncovered(word_at(tile, at, 1), tile.layer));
}

float nearest_in(LayerTile tile) {
    float nearest = 1e30;
    ivec2 first = tile.at * tile.reduction, end = min(first + tile.reduction, picture_tiles);
    for (int y = first.y; y < end.y; ++y)
        for (int x = first.x; x < end.x; ++x) nearest = min(nearest, nearest_buf[y * picture_tiles.x + x]);
    return nearest;
}

void empty_list(LayerTile tile) {
    int first = tile.layer * list_words;
    for (int i = 0; i < TILE_LIST_HEAD; ++i) tile_list_buf[first + i] = 0u;
    tile_list_buf[first + 1] = tile_list_buf[first + 2] = 1u;
    tile_list_buf[first + 4] = tile_list_buf[first + 5] = uint(tile.reduction);
}

void main() {
    LayerTile tile = layer_tile();
    if (any(greaterThanEqual(tile.at, tile.count))) return;
    if (tile.at == ivec2(0)) empty_list(tile);
    ivec2 away = ivec2(FAR_AWAY);
    for (int step = 0; step <= tile.reach && max(away.x, away.y) == FAR_AWAY; ++step) {
        bvec2 before = found_at(tile, tile.at - ivec2(step, 0)), after = found_at(tile, tile.at + ivec2(step, 0));
        if (before.x || after.x) away.x = min(away.x, step);
        if (before.y || after.y) away.y = min(away.y, step);
    }
    distance_buf[word_of(tile, tile.at)] = uint(away.y) << 16 | uint(away.x);
    hider_buf[word_of(tile, tile.at)] = nearest_in(tile);
}

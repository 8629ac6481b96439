// Finds the tiles in which a layer's blur can be visible or is needed: near its content, and where a
// nearer blur uncovers it. All layers at once.
//
// Inputs (one of each a tile of each layer)
//   distance_buf   tiles along the row to the next with content, and to the next that is uncovered
//                  (tile_reach_rows.comp.glsl)
//   hider_buf      least signed coc in the tile, pixels of the picture
// Output
//   tile_mask_buf  see lib/tile_mask.lib.glsl
//   tile lists     the same tiles one by one (lib/tile_list.lib.glsl)

#include "lib/tile_reach.lib.glsl"

layout(local_size_x = TILE_GROUP, local_size_y = TILE_GROUP) in;

uniform vec2 layer_px[2 * LAYERS_MAX];  // how far a layer's content spreads by its own blur; its widest |coc|
uniform float wider_scale;          // axis scale of the wider axis
uniform float margin_px;
uniform int slices;                 // number of slices in which a later pass works through a list
layout(std430) readonly buffer distance_block { uint distance_buf[]; };
layout(std430) readonly buffer hider_block { float hider_buf[]; };
layout(std430) writeonly buffer tile_mask_block { uint tile_mask_buf[]; };

// Picture pixels between the nearest corners of two tiles this many tiles apart.
float gap_px(LayerTile tile, int tiles_away) {
    return float(max(tiles_away - 1, 0) * TILE * tile.reduction);
}

float nearer_px(LayerTile tile, float away, int across, int down) {
    vec2 gap = vec2(gap_px(tile, across), gap_px(tile, down));
    return across < FAR_AWAY ? min(away, length(gap)) : away;
}

// The distance to the layer's content, and to where it is uncovered: it shows only near both.
float away_px(LayerTile tile) {
    vec2 away = vec2(1e30);
    int first = max(tile.at.y - tile.reach, 0), last = min(tile.at.y + tile.reach, tile.count.y - 1);
    for (int y = first; y <= last; ++y) {
        uint across = distance_buf[word_of(tile, ivec2(tile.at.x, y))];
        away.x = nearer_px(tile, away.x, int(across & 0xffffu), abs(y - tile.at.y));
        away.y = nearer_px(tile, away.y, int(across >> 16), abs(y - tile.at.y));
    }
    return max(away.x, away.y);
}

void list_tile(LayerTile tile) {
    int first = tile.layer * list_words;
    uint slot = atomicAdd(tile_list_buf[first + 6], 1u), parts = uint(slices);
    if (slot % parts == 0u && slot / parts < TILE_GROUPS_MAX) atomicAdd(tile_list_buf[first], 1u);
    if (slot < TILE_GROUPS_MAX) atomicAdd(tile_list_buf[first + 3], 1u);
    tile_list_buf[first + TILE_LIST_HEAD + int(slot)] = uint(tile.at.y) << 16 | uint(tile.at.x);
}

void main() {
    LayerTile tile = layer_tile();
    if (any(greaterThanEqual(tile.at, tile.count))) return;
    vec2 px = layer_px[tile.layer];
    float uncovered_px = wider_scale * (max(-hider_buf[word_of(tile, tile.at)], 0.0) + px.y) / 2.0;
    bool is_needed = away_px(tile) <= max(px.x, uncovered_px) + margin_px;
    tile_mask_buf[word_of(tile, tile.at)] = is_needed ? 1u : 0u;
    if (is_needed) list_tile(tile);
}

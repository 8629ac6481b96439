// Finds the tiles in which a layer's blur can be visible or is needed: near its content, and where all nearer layers
// are open within reach. Does this for all layers at once: an invocation handles one tile of one layer.
//
// Words: reach, the distance to which content or an opening has an effect; hole, a tile in which a layer is open, so
// that something farther may be seen through it (lib/tile_content.lib.glsl); coc, signed circle of confusion, diameter
// in pixels, negative in front of the focus. The same layer can be there twice, at two sizes.
//
// Inputs (all from tile_reach_rows.comp.glsl)
//   distance_buf   for each tile of a layer the number of tiles along the row to the next with content, or FAR_AWAY
//   hole_buf       for each tile of the picture the same to the next hole of the layer
//   hider_buf      for each tile of a layer the least coc in the tile, in pixels of the picture
// Outputs
//   tile_mask_buf  1 for active tiles, else 0
//   tile lists     the active tiles one by one (lib/tile_list.lib.glsl)

#include "lib/tile_reach.lib.glsl"  // FAR_AWAY, TILE_GROUPS_MAX, LayerTile, layer_tile, tile_index, hole_index ...

layout(local_size_x = TILE_GROUP, local_size_y = TILE_GROUP) in;

uniform vec2 layer_px[2 * LAYERS_MAX];  // x reach of a layer's content by its own blur, y its widest |coc|, pixels
uniform float wider_scale;          // half extent of the lens's disc along its wider axis, for a radius of 1
uniform float margin_px;            // added to every reach
uniform int layer_count;
uniform int slices;                 // number of slices in which a later pass works through a list
layout(std430) readonly buffer distance_block { int distance_buf[]; };
layout(std430) readonly buffer hole_block { int hole_buf[]; };
layout(std430) readonly buffer hider_block { float hider_buf[]; };
layout(std430) writeonly buffer tile_mask_block { uint tile_mask_buf[]; };

// Distance in pixels between the nearest points of two tiles that are this many tiles of the picture apart.
float gap_px(int across, int down) { return length(vec2(max(ivec2(across, down) - 1, 0) * TILE)); }

// Distance from a tile to the nearest tile with content of its layer, pixels; 1e30 for none within reach.
float content_distance_px(LayerTile tile) {
    float distance_px = 1e30;
    int first = max(tile.at.y - tile.reach, 0), last = min(tile.at.y + tile.reach, tile.count.y - 1);
    for (int y = first; y <= last; ++y) {
        int across = distance_buf[tile_index(tile, ivec2(tile.at.x, y))];
        vec2 gap = vec2(max(ivec2(across, abs(y - tile.at.y)) - 1, 0) * TILE * tile.reduction);
        if (across < FAR_AWAY) distance_px = min(distance_px, length(gap));
    }
    return distance_px;
}

// True if the layer of another entry has a hole within `reach_px` of a tile.
bool has_hole(LayerTile tile, int entry, float reach_px) {
    ivec2 first = tile.at * tile.reduction, last = min(first + tile.reduction, picture_tiles) - 1;
    int reach = int(reach_px) / TILE + 1, end = min(last.y + reach, picture_tiles.y - 1);
    float distance_px = 1e30;
    int y = max(first.y - reach, 0);
    do {
        int across = min(hole_buf[hole_index(entry, ivec2(first.x, y))], hole_buf[hole_index(entry, ivec2(last.x, y))]);
        if (across < FAR_AWAY) distance_px = min(distance_px, gap_px(across, max(max(first.y - y, y - last.y), 0)));
    } while (++y <= end);
    return distance_px <= reach_px;
}

// True if some nearer layer has no hole within `reach_px` of the tile.
bool is_covered(LayerTile tile, float reach_px) {
    bool is_open = true;
    for (int other = tile.entry + 1; other < layer_count && is_open; ++other)
        if (layer_number[other] > layer_number[tile.entry]) is_open = has_hole(tile, other, reach_px);
    return !is_open;
}

// Appends an active tile to the list of its layer.
void list_tile(LayerTile tile) {
    int first = tile.entry * list_words;
    // Words 0 and 3 are the workgroups of two later passes, word 6 is the number of tiles.
    // A pass over the layer's tiles runs in `slices` equal slices, so it needs one group more for each `slices` tiles.
    uint slot = atomicAdd(tile_list_buf[first + 6], 1u), slice_count = uint(slices);
    if (slot % slice_count == 0u && slot / slice_count < TILE_GROUPS_MAX) atomicAdd(tile_list_buf[first], 1u);
    if (slot < TILE_GROUPS_MAX) atomicAdd(tile_list_buf[first + 3], 1u);
    tile_list_buf[first + TILE_LIST_HEAD + int(slot)] = uint(tile.at.y) << 16 | uint(tile.at.x);
}

void main() {
    LayerTile tile = layer_tile();
    if (any(greaterThanEqual(tile.at, tile.count))) return;
    vec2 px = layer_px[tile.entry];
    // uncovered_px: as far as the nearest surface and this layer move relative to each other, seen across the lens.
    float uncovered_px = wider_scale * (max(-hider_buf[tile_index(tile, tile.at)], 0.0) + px.y) / 2.0;
    float reach_px = max(px.x, uncovered_px) + margin_px;
    bool is_needed = content_distance_px(tile) <= reach_px && !is_covered(tile, reach_px);
    tile_mask_buf[tile_index(tile, tile.at)] = is_needed ? 1u : 0u;
    if (is_needed) list_tile(tile);
}

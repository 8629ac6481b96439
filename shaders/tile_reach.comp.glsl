// Finds the tiles in which a layer's blur can be visible or is needed: near its content, and where a
// nearer blur uncovers it.
//
// Inputs (one of each a tile of the layer)
//   distance_buf   tiles along the row to the next with content (tile_reach_rows.comp.glsl)
//   hider_buf      least signed coc in the tile, pixels of the picture
// Output
//   tile_mask_buf  see lib/tile_mask.lib.glsl
//   tile list      the same tiles one by one (lib/tile_list.lib.glsl)

#include "lib/tile_list.lib.glsl"
#include "lib/tile_reach.lib.glsl"

layout(local_size_x = TILE_GROUP, local_size_y = TILE_GROUP) in;

uniform float tile_px;     // picture pixels a side of a tile
uniform float spread_px;   // how far content spreads by its own blur, picture pixels
uniform float widest_px;   // widest |coc| in the layer
uniform float wider_scale; // axis scale of the wider axis
uniform float margin_px;
uniform int slices;        // number of slices in which a later pass works through the list
layout(std430) readonly buffer distance_block { int distance_buf[]; };
layout(std430) readonly buffer hider_block { float hider_buf[]; };
layout(std430) writeonly buffer tile_mask_block { uint tile_mask_buf[]; };

// Pixels between the nearest corners of two tiles this many tiles apart.
float gap_px(int tiles_away) { return float(max(tiles_away - 1, 0)) * tile_px; }

void main() {
    ivec2 tile = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(tile, tiles))) return;
    float away_px = 1e30;
    for (int y = max(tile.y - reach_tiles, 0); y <= min(tile.y + reach_tiles, tiles.y - 1); ++y) {
        int across = distance_buf[y * tiles.x + tile.x];
        if (across < FAR_AWAY) away_px = min(away_px, length(vec2(gap_px(across), gap_px(abs(y - tile.y)))));
    }
    int here = tile.y * tiles.x + tile.x;
    float uncovered_px = wider_scale * (max(-hider_buf[here], 0.0) + widest_px) / 2.0;
    float reach_px = max(spread_px, uncovered_px) + margin_px;
    bool is_needed = away_px <= reach_px;
    tile_mask_buf[here] = is_needed ? 1u : 0u;
    if (is_needed) list_tile(tile, uint(slices));
}

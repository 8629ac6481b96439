// Measures the distance of each of a layer's tiles, along its row, to the next one with content.
//
// A tile of a layer processed at 1/2, 1/4 or 1/8 size stands for several tiles of the picture.
//
// Inputs
//   content_buf, nearest_buf   of the picture's tiles (tile_layers.comp.glsl)
// Outputs (one of each a tile of the layer)
//   distance_buf   tiles along the row to the next with content, FAR_AWAY: there is none
//   hider_buf      least signed coc in the tile, pixels of the picture

#include "lib/tile_reach.lib.glsl"

layout(local_size_x = TILE_GROUP, local_size_y = TILE_GROUP) in;

uniform ivec2 picture_tiles;  // across, down
uniform int reduction;        // size of a pixel of the layer, in picture pixels
uniform int layer;
layout(std430) readonly buffer content_block { uint content_buf[]; };
layout(std430) readonly buffer nearest_block { float nearest_buf[]; };
layout(std430) writeonly buffer distance_block { int distance_buf[]; };
layout(std430) writeonly buffer hider_block { float hider_buf[]; };

bool has_content(ivec2 tile) {
    uint content = 0u;
    for (int y = tile.y * reduction; y < min((tile.y + 1) * reduction, picture_tiles.y); ++y)
        for (int x = tile.x * reduction; x < min((tile.x + 1) * reduction, picture_tiles.x); ++x)
            content |= content_buf[y * picture_tiles.x + x];
    return (content >> layer & 1u) != 0u;
}

float nearest_in(ivec2 tile) {
    float nearest = 1e30;
    for (int y = tile.y * reduction; y < min((tile.y + 1) * reduction, picture_tiles.y); ++y)
        for (int x = tile.x * reduction; x < min((tile.x + 1) * reduction, picture_tiles.x); ++x)
            nearest = min(nearest, nearest_buf[y * picture_tiles.x + x]);
    return nearest;
}

void main() {
    ivec2 tile = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(tile, tiles))) return;
    int away = FAR_AWAY;
    for (int step = 0; step <= reach_tiles && away == FAR_AWAY; ++step) {
        bool before = tile.x - step >= 0 && has_content(tile - ivec2(step, 0));
        bool after = tile.x + step < tiles.x && has_content(tile + ivec2(step, 0));
        if (before || after) away = step;
    }
    distance_buf[tile.y * tiles.x + tile.x] = away;
    hider_buf[tile.y * tiles.x + tile.x] = nearest_in(tile);
}

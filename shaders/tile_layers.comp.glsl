// Finds the layers with content in each tile of the picture, those that are seen in the pinhole picture,
// and the nearest circle of confusion there.
//
// Inputs
//   coc_tx      signed coc, pixels
//   kind_tx, near_tx   fragments of rim pixels
// Output
//   content_buf bit l: layer l has content in the tile; bit SEEN_BITS + l: some of it is seen
//   nearest_buf least signed coc in the tile, pixels

#include "lib/kind.lib.glsl"
#include "lib/tile_content.lib.glsl"

#ifdef LISTS
#include "lib/fragment_list.lib.glsl"
#endif

// A GPU looks at all rows of a tile at once.
#ifndef ROWS_AT_ONCE
#define ROWS_AT_ONCE 1
#endif
layout(local_size_x = TILE_GROUP, local_size_y = TILE_GROUP, local_size_z = ROWS_AT_ONCE) in;

uniform sampler2D coc_tx;
uniform sampler2D kind_tx;
uniform sampler2D near_tx;
uniform ivec2 tiles;                    // across, down
uniform vec2 layer_ends_px[2 * LAYERS_MAX]; // signed coc where each layer's membership begins and ends
uniform int layer_count;
layout(std430) writeonly buffer content_block { uint content_buf[]; };
layout(std430) writeonly buffer nearest_block { float nearest_buf[]; };

uint layers_of(vec2 cocs) {
    uint bits = 0u;
    int l = 0;
    do {
        bvec2 are_in = bvec2(uvec2(greaterThan(cocs, layer_ends_px[l].xx)) & uvec2(lessThan(cocs, layer_ends_px[l].yy)));
        bits |= uint(any(are_in)) << l;
    } while (++l < layer_count);
    return bits;
}

void look_at(ivec2 at, inout uint content, inout float nearest) {
    float coc = texelFetch(coc_tx, at, 0).r;
    float other = texelFetch(kind_tx, at, 0).r == FAR_RIM ? texelFetch(near_tx, at, 0).a : coc;
    content |= with_seen(layers_of(vec2(coc, other)), true);
    nearest = min(nearest, coc);
#ifdef LISTS
    List list = list_at(at);
    uint last = list.end - 1u, listed = 0u;
    if (list.first < list.end) do {
        listed |= layers_of(vec2(fragment_of(list.first).coc, fragment_of(min(list.first + 1u, last)).coc));
    } while ((list.first += 2u) < list.end);
    content |= with_seen(listed, list.has_front || is_open);
#endif
}

#if ROWS_AT_ONCE > 1
shared uint content_sh[TILE_GROUP * TILE_GROUP];
shared uint nearest_sh[TILE_GROUP * TILE_GROUP];

// Whole numbers in the order of the floats.
uint in_order(float a) {
    uint bits = floatBitsToUint(a);
    return bits >> 31 == 1u ? ~bits : bits | 0x80000000u;
}
float from_order(uint a) { return uintBitsToFloat(a >> 31 == 1u ? a & 0x7fffffffu : ~a); }

// Joins what the invocations with the rows of a tile have found.
void join_rows(inout uint content, inout float nearest) {
    int tile = int(gl_LocalInvocationID.y) * TILE_GROUP + int(gl_LocalInvocationID.x);
    if (gl_LocalInvocationID.z == 0u) {
        content_sh[tile] = 0u;
        nearest_sh[tile] = 0xffffffffu;
    }
    barrier();
    atomicOr(content_sh[tile], content);
    atomicMin(nearest_sh[tile], in_order(nearest));
    barrier();
    content = content_sh[tile];
    nearest = from_order(nearest_sh[tile]);
}
#endif

void main() {
    ivec2 tile = ivec2(gl_GlobalInvocationID.xy);
    ivec2 first = tile * TILE, end = min(first + TILE, textureSize(coc_tx, 0));
    uint content = 0u;
    float nearest = 1e30;
    for (int y = first.y + int(gl_LocalInvocationID.z); y < end.y; y += ROWS_AT_ONCE)
        for (int x = first.x; x < end.x; ++x) look_at(ivec2(x, y), content, nearest);
#if ROWS_AT_ONCE > 1
    join_rows(content, nearest);
#endif
    if (any(greaterThanEqual(tile, tiles)) || gl_LocalInvocationID.z > 0u) return;
    content_buf[tile.y * tiles.x + tile.x] = content;
    nearest_buf[tile.y * tiles.x + tile.x] = nearest;
}

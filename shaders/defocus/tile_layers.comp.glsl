// Finds, for each tile of the picture, the layers that have content there, and the layers that are open: something
// farther may be seen through them. A layer is a range of signed coc (circle of confusion: diameter in pixels, negative
// in front of the focus); layers are numbered from the farthest on. Also finds the least and the greatest coc in each
// tile.
//
// Inputs
//   coc_tx      r coc
//   kind_tx     r kind of the pixel (lib/kind.lib.glsl)
//   near_tx     a coc of the second surface of edge pixels (unmix_far.comp.glsl, unmix_near.comp.glsl)
//   with LISTS: fragment lists (lib/fragment_list.lib.glsl)
// Outputs
//   content_buf       a word for each tile: bit l is set if layer l has content there, bit OPEN_BITS + l if it is open
//   out_coc_range_img   r least coc in the tile, of visible and listed surfaces, g greatest one of visible surfaces,
//                     FARTHEST_PX where something may be seen through one

#include "lib/kind.lib.glsl"  // FAR_EDGE, NEAR_EDGE
#include "lib/tile_content.lib.glsl"  // OPEN_BITS

#ifdef LISTS
#include "lib/fragment_list.lib.glsl"  // List, list_at, fragment_of, is_open, Fragment
#endif

// A GPU processes all rows of a tile at once.
#ifndef ROWS_AT_ONCE
#define ROWS_AT_ONCE 1
#endif
layout(local_size_x = TILE_GROUP, local_size_y = TILE_GROUP, local_size_z = ROWS_AT_ONCE) in;

uniform sampler2D coc_tx;
uniform sampler2D kind_tx;
uniform sampler2D near_tx;
uniform ivec2 tiles;                    // across, down
// Four signed coc of each cut between two layers, far to near: up to the first there is only the nearer layer, up to
// the second it covers in full; from the third on the farther layer covers in full, from the fourth on it is alone.
uniform vec4 cuts_px[LAYERS_MAX - 1];
layout(std430) writeonly buffer content_block { uint content_buf[]; };
layout(rg32f) uniform writeonly image2D out_coc_range_img;

#define FARTHEST_PX 1e30
#define OPAQUE 0.9995  // a surface of this coverage or more hides everything behind it

// The layers of the surfaces of a pixel, as bits.
struct Known {
    uint content;  // a surface is in the layer, in full or in part
    uint closed;   // an opaque surface covers the layer in full
    uint reached;  // a surface is known in the layer or farther
};

// The bits of a layer and of all nearer ones.
uint all_from(int layer) { return ~0u << layer; }

// Adds a surface of a pixel to its layers.
void add_surface(inout Known known, float coc, bool is_opaque) {
    ivec4 farther_cuts = ivec4(0);  // how many cuts are farther, for each of the four coc
    for (int cut = 0; cut < LAYERS_MAX - 1; ++cut) farther_cuts += ivec4(lessThan(vec4(coc), cuts_px[cut]));
    known.content |= all_from(farther_cuts.x) & ~all_from(farther_cuts.w + 1);
    known.closed |= uint(is_opaque && farther_cuts.y == farther_cuts.z) << farther_cuts.z;
    known.reached |= all_from(farther_cuts.x);
}

// Adds the layers of a pixel to those of its tile.
void add_pixel(ivec2 at, inout uint content, inout vec2 coc_range) {
    float coc = texelFetch(coc_tx, at, 0).r, kind = texelFetch(kind_tx, at, 0).r;
    // other: coc of the second surface of a edge pixel.
    float other = kind == FAR_EDGE || kind == NEAR_EDGE ? texelFetch(near_tx, at, 0).a : coc;
    bool is_whole = true;
#ifdef LISTS
    List list = list_at(at);
    is_whole = !list.has_front && !(is_open && list.first < list.end);
#endif
    coc_range = vec2(min(coc_range.x, coc), max(coc_range.y, is_whole ? max(coc, other) : FARTHEST_PX));
    Known known = Known(0u, 0u, 0u), other_side = known;
    add_surface(known, coc, is_whole);
    add_surface(other_side, other, is_whole);
    if (kind == FAR_EDGE) known.content |= other_side.content;
    if (kind == NEAR_EDGE) known.closed &= other_side.closed;  // light shines through, except within the layer
#ifdef LISTS
    if (list.first < list.end) do {
        Fragment fragment = fragment_of(list.first);
        add_surface(known, fragment.coc, !is_open && fragment.cover >= OPAQUE);
        coc_range.x = min(coc_range.x, fragment.coc);
    } while (++list.first < list.end);
#endif
    content |= known.content | (known.reached & ~known.closed) << OPEN_BITS;
}

#if ROWS_AT_ONCE > 1
shared uint content_sh[TILE_GROUP * TILE_GROUP];
shared uint least_sh[TILE_GROUP * TILE_GROUP];
shared uint greatest_sh[TILE_GROUP * TILE_GROUP];

// Converts a float to a whole number and back; the numbers have the order of the floats, as atomicMin and atomicMax need.
uint to_order(float a) {
    uint bits = floatBitsToUint(a);
    return bits >> 31 == 1u ? ~bits : bits | 0x80000000u;
}
float from_order(uint a) { return uintBitsToFloat(a >> 31 == 1u ? a & 0x7fffffffu : ~a); }

// Joins what the invocations with the rows of a tile have found.
void join_rows(inout uint content, inout vec2 coc_range) {
    int tile = int(gl_LocalInvocationID.y) * TILE_GROUP + int(gl_LocalInvocationID.x);
    if (gl_LocalInvocationID.z == 0u) {
        content_sh[tile] = 0u;
        least_sh[tile] = 0xffffffffu;
        greatest_sh[tile] = 0u;
    }
    barrier();
    atomicOr(content_sh[tile], content);
    atomicMin(least_sh[tile], to_order(coc_range.x));
    atomicMax(greatest_sh[tile], to_order(coc_range.y));
    barrier();
    content = content_sh[tile];
    coc_range = vec2(from_order(least_sh[tile]), from_order(greatest_sh[tile]));
}
#endif

void main() {
    ivec2 tile = ivec2(gl_GlobalInvocationID.xy);
    ivec2 first = tile * TILE, end = min(first + TILE, textureSize(coc_tx, 0));
    uint content = 0u;
    vec2 coc_range = vec2(FARTHEST_PX, -FARTHEST_PX);
    for (int y = first.y + int(gl_LocalInvocationID.z); y < end.y; y += ROWS_AT_ONCE)
        for (int x = first.x; x < end.x; ++x) add_pixel(ivec2(x, y), content, coc_range);
#if ROWS_AT_ONCE > 1
    join_rows(content, coc_range);
#endif
    if (any(greaterThanEqual(tile, tiles)) || gl_LocalInvocationID.z > 0u) return;
    content_buf[tile.y * tiles.x + tile.x] = content;
    imageStore(out_coc_range_img, tile, vec4(coc_range, 0.0, 0.0));
}

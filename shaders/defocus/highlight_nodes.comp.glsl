// Places the nodes of each disc, at which highlight_shadow.comp.glsl works out how much of its highlight is hidden, and finds
// the nearest surface that a ray from the lens to the highlight may meet: no nearer ones need be looked for. One disc an
// invocation. A highlight of a listed surface is wholly hidden where all that is visible around it, as far as rays to it
// go, is nearer. (coc: signed circle of confusion, diameter in pixels, negative in front of the focus.)
//
// Inputs
//   plan           the number of discs
//   coc_range_tx   r least coc of each tile, g greatest one of its visible surfaces (tile_layers.comp.glsl)
// In and out
//   sprite_buf     the discs, which get their nodes
// Output
//   pixel list     the nodes of all discs: x the number of a disc, y that of a node in it

#include "lib/aperture.lib.glsl"  // aperture_reach, SMOOTH_WIDTH
#include "lib/highlights.lib.glsl"  // Plan, Sprite, margin_of, NOT_HIDDEN, ALL_HIDDEN, LARGE_DISC
#include "lib/pixel_list.lib.glsl"  // list_groups, list_count, list_pixels, GROUPS_MAX, PIXELS_PER_GROUP
#include "lib/highlight_nodes.lib.glsl"  // coc_of

layout(local_size_x = PIXELS_PER_GROUP) in;

layout(std430) readonly buffer plan_block { Plan plan; };
layout(std430) buffer sprite_block { Sprite sprite_buf[]; };

uniform sampler2D coc_range_tx;
uniform float nearest_px;  // least coc of the picture
uniform uint nodes_max;    // of all discs

#define FARTHEST_PX 1e30
#define TILES_MOST 24  // largest number of tiles to read in a row
#define LOOKUP_PX 3.0  // added to the reach: rays read 2 x 2 pixels, which know of surfaces beside them
#define POINTS_PX 0.34  // at most from the middle of a pixel to the points of lib/pixel_cover.lib.glsl
#define SIDE_MOST 12.0  // nodes in a row: larger discs leave few lanes idle

// Least signed coc of the tiles within `reach` of a position, and greatest one of their visible surfaces; the least of the
// picture, and the greatest of all, if there are too many tiles.
vec2 coc_range_within(vec2 center, vec2 reach) {
    ivec2 last_tile = textureSize(coc_range_tx, 0) - 1;
    ivec2 first = clamp(ivec2(floor((center - reach) / float(TILE))), ivec2(0), last_tile);
    ivec2 last = clamp(ivec2(floor((center + reach) / float(TILE))), ivec2(0), last_tile);
    if (any(greaterThan(last - first, ivec2(TILES_MOST)))) return vec2(nearest_px, FARTHEST_PX);
    vec2 range = vec2(FARTHEST_PX, -FARTHEST_PX);
    for (int y = first.y; y <= last.y; ++y)
        for (int x = first.x; x <= last.x; ++x) {
            vec2 of_tile = texelFetch(coc_range_tx, ivec2(x, y), 0).rg;
            range = vec2(min(range.x, of_tile.x), max(range.y, of_tile.y));
        }
    return range;
}

// The largest number of nodes in a row of which each of all discs may have a square.
float side_most() { return min(floor(sqrt(float(nodes_max) / float(plan.draw[1]))), SIDE_MOST); }

void main() {
    uint number = gl_GlobalInvocationID.x;
    if (number >= plan.draw[1]) return;
    Sprite sprite = sprite_buf[number];
    float coc = coc_of(sprite.disc), hiding_px = coc - margin_of(coc);
    // At the nearest depth, rays to the disc lie within the disc's reach times `wider`.
    float wider = max((coc - nearest_px) / abs(coc), 1.0);
    vec2 reach = aperture_reach(0.5 * coc, sprite.disc.w) + 1.0;
    vec2 range = coc_range_within(sprite.disc.xy, wider * reach + LOOKUP_PX);
    vec2 covered = aperture_reach(0.5 * coc, SMOOTH_WIDTH * sprite.disc.w) + POINTS_PX;
    vec2 first = ceil(sprite.disc.xy - covered - 0.5);
    vec2 sides = floor(sprite.disc.xy + covered - 0.5) - first + 1.0;
    float side = max(max(sides.x, sides.y), 1.0);
    if (side > side_most()) side = LARGE_DISC;
    if (range.x >= hiding_px) side = NOT_HIDDEN;
    if (range.y < hiding_px) side = ALL_HIDDEN;
    uint count = side > 0.0 ? uint(side * side) : 0u, slot = atomicAdd(list_count, count), end = slot + count;
    atomicMax(list_groups[0], min((end + PIXELS_PER_GROUP - 1u) / PIXELS_PER_GROUP, GROUPS_MAX));
    for (uint node = 0u; node < count; ++node) list_pixels[slot + node] = node << 16 | number;
    sprite_buf[number].light.a = range.x;
    sprite_buf[number].nodes = vec4(first, side, float(slot));
}

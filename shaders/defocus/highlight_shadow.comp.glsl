// Traces the rays to highlights at the nodes of their discs (lib/highlight_nodes.lib.glsl), one node an invocation.
//
// Inputs
//   pixel list   the nodes: x the number of a disc, y that of a node (highlight_nodes.comp.glsl)
//   sprite_buf   the discs
//   those of lib/highlight_rays.lib.glsl; with LISTS fragment lists (lib/fragment_list.lib.glsl)
// Output
//   pixel list   in the place of each node the hidden share of the highlight, 0..1, as the bits of a float

#include "lib/highlights.lib.glsl"  // Sprite
#include "lib/highlight_rays.lib.glsl"  // mean_hidden_share
#include "lib/pixel_list.lib.glsl"  // FOR_EACH_LISTED, PIXELS_PER_GROUP
#include "lib/highlight_nodes.lib.glsl"  // coc_of, node_slot

layout(local_size_x = PIXELS_PER_GROUP) in;

layout(std430) readonly buffer sprite_block { Sprite sprite_buf[]; };

void trace_node(ivec2 listed) {
    Sprite sprite = sprite_buf[listed.x];
    int side = int(sprite.nodes.z);
    ivec2 node = ivec2(listed.y % side, listed.y / side);
    vec2 at = sprite.nodes.xy + vec2(node) + 0.5;
    float share = mean_hidden_share(at, sprite.disc.xy, coc_of(sprite.disc), sprite.disc.w, sprite.light.a);
    list_pixels[node_slot(sprite.nodes, node)] = floatBitsToUint(share);
}

void main() { FOR_EACH_LISTED(trace_node) }

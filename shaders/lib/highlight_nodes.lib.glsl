// The nodes of a disc: the pixels at which it is worked out how much of its highlight is hidden, before it is drawn. A
// drawn disc of few pixels leaves most lanes of a processor idle.
//
//   nodes   of a Sprite (lib/highlights.lib.glsl): x, y the first pixel; z the number of pixels across and down, or one
//           of the numbers of lib/highlights.lib.glsl; w the index of the first node in the list

#include "lib/pixel_list.lib.glsl"  // list_pixels

#define LEAST_COC_PX 1e-3

// The coc of a disc; not 0, because rays divide by it.
float coc_of(vec4 disc) { return abs(disc.z) < LEAST_COC_PX ? LEAST_COC_PX : disc.z; }

// The place in the list of the node in this column and row.
uint node_slot(vec4 nodes, ivec2 node) { return uint(nodes.w) + uint(node.y * int(nodes.z) + node.x); }

float node_share(vec4 nodes, ivec2 node) { return uintBitsToFloat(list_pixels[node_slot(nodes, node)]); }

// The hidden share of a highlight at a position in the picture, 0..1, interpolated between the nodes.
float share_between_nodes(vec2 position, vec4 nodes) {
    if (nodes.z <= 0.0) return 0.0;
    vec2 at = clamp(position - 0.5 - nodes.xy, 0.0, nodes.z - 1.0);
    ivec2 low = ivec2(at), high = min(low + 1, ivec2(nodes.z) - 1);
    float upper = mix(node_share(nodes, low), node_share(nodes, ivec2(high.x, low.y)), fract(at.x));
    float lower = mix(node_share(nodes, ivec2(low.x, high.y)), node_share(nodes, high), fract(at.x));
    return mix(upper, lower, fract(at.y));
}

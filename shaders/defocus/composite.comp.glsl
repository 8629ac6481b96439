// Composites a blurred layer that is smaller than the picture over the layers behind it. (The blur itself composites
// layers of full size.)
//
// A layer can be processed at two sizes that are mixed, so that a change from one size to the other is not visible:
// first the larger size is composited without MIXED, then the smaller one with MIXED.
//
// Inputs
//   layer_tx        the layer: rgb times coverage, a coverage, both blurred; inactive tiles are read as empty
//   with MIXED:
//   behind_tx       rgb of the layers behind this one
//   share           weight of the smaller size in the mix, 0 to 1
// In and out
//   out_color_img   rgb of the picture so far: before the pass the layers behind (with MIXED: the layers behind
//                   and the larger size of this one), after it with this layer too; a 1

#include "lib/over.lib.glsl"  // composite_over
#include "lib/tile_list.lib.glsl"  // FOR_EACH_TILE
#include "lib/tile_mask.lib.glsl"  // is_active

layout(local_size_x = TILE, local_size_y = TILE) in;

uniform sampler2D layer_tx;
layout(rgba32f) uniform image2D out_color_img;

uniform int reduction;     // side of a pixel of the layer, in pixels of the picture
uniform ivec2 layer_size;  // in pixels of its own; it is in the corner of layer_tx

// A pixel of the layer; empty in inactive tiles, which hold no values.
vec4 layer_texel(ivec2 at) { return is_active(at) ? texelFetch(layer_tx, at, 0) : vec4(0.0); }

// The layer at a pixel of the picture, interpolated linearly.
vec4 layer_at(ivec2 at) {
    vec2 position = (vec2(at) + 0.5) / float(reduction) - 0.5;
    ivec2 low = ivec2(floor(position)), last = layer_size - 1;
    ivec2 a = clamp(low, ivec2(0), last), b = clamp(low + 1, ivec2(0), last);
    vec2 fraction = position - vec2(low);
    vec4 above = mix(layer_texel(a), layer_texel(ivec2(b.x, a.y)), fraction.x);
    vec4 below = mix(layer_texel(ivec2(a.x, b.y)), layer_texel(b), fraction.x);
    return mix(above, below, fraction.y);
}

// What the layer is composited over, and how the result is combined with the picture so far.
#ifdef MIXED
uniform sampler2D behind_tx;
uniform float share;

vec3 behind_at(ivec2 at) { return texelFetch(behind_tx, at, 0).rgb; }
vec3 cross_fade_at(ivec2 at, vec3 color) { return mix(imageLoad(out_color_img, at).rgb, color, share); }
#else
vec3 behind_at(ivec2 at) { return imageLoad(out_color_img, at).rgb; }
vec3 cross_fade_at(ivec2 at, vec3 color) { return color; }
#endif

// Composites the layer at one pixel of the picture.
void composite(ivec2 at) {
    vec3 color = composite_over(layer_at(at), behind_at(at)).rgb;
    imageStore(out_color_img, at, vec4(cross_fade_at(at, color), 1.0));
}

// Composites the picture pixels of a workgroup in a tile of the layer. A tile of the layer stands for `reduction` x
// `reduction` workgroups: x of a workgroup chooses the tiles (FOR_EACH_TILE), y and z the part of the tile.
void composite_tile(ivec2 tile) {
    ivec2 groups = tile * ivec2(gl_NumWorkGroups.yz) + ivec2(gl_WorkGroupID.yz);
    ivec2 at = groups * TILE + ivec2(gl_LocalInvocationID.xy);
    if (all(lessThan(at, imageSize(out_color_img)))) composite(at);
}

void main() { FOR_EACH_TILE(composite_tile) }

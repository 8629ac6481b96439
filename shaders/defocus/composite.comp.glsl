// Composites a blurred layer that is smaller than the picture; whole ones are composited by the blur itself.
//
// Inputs
//   layer_tx        rgb times coverage, a coverage, both blurred; tiles that are not active are empty,
//                   whatever is stored there
//   with MIXED, for a layer of which the larger size is already in out_color_img:
//   behind_tx       rgb so far without the layer; `share` is how much the smaller one counts
// Output
//   out_color_img   rgb so far (read and written); a 1

#include "lib/over.lib.glsl"
#include "lib/tile_list.lib.glsl"
#include "lib/tile_mask.lib.glsl"

layout(local_size_x = TILE, local_size_y = TILE) in;

uniform sampler2D layer_tx;
layout(rgba32f) uniform image2D out_color_img;

uniform int reduction;     // side of a pixel of the layer, in pixels of the picture
uniform ivec2 layer_size;  // in pixels of its own; it is in the corner of layer_tx

vec4 active_at(ivec2 at) { return is_active(at) ? texelFetch(layer_tx, at, 0) : vec4(0.0); }

vec4 layer_at(ivec2 at) {
    vec2 place = (vec2(at) + 0.5) / float(reduction) - 0.5;
    ivec2 low = ivec2(floor(place)), last = layer_size - 1;
    ivec2 a = clamp(low, ivec2(0), last), b = clamp(low + 1, ivec2(0), last);
    vec2 part = place - vec2(low);
    vec4 above = mix(active_at(a), active_at(ivec2(b.x, a.y)), part.x);
    vec4 below = mix(active_at(ivec2(a.x, b.y)), active_at(b), part.x);
    return mix(above, below, part.y);
}

#ifdef MIXED
uniform sampler2D behind_tx;
uniform float share;

vec3 behind_at(ivec2 at) { return texelFetch(behind_tx, at, 0).rgb; }
vec3 shared_at(ivec2 at, vec3 color) { return mix(imageLoad(out_color_img, at).rgb, color, share); }
#else
vec3 behind_at(ivec2 at) { return imageLoad(out_color_img, at).rgb; }
vec3 shared_at(ivec2 at, vec3 color) { return color; }
#endif

void composite(ivec2 at) {
    vec3 color = composited(layer_at(at), behind_at(at)).rgb;
    imageStore(out_color_img, at, vec4(shared_at(at, color), 1.0));
}

// A workgroup's part of a tile: with a reduction of 2, a tile stands for 2 x 2 workgroups.
void composite_tile(ivec2 tile) {
    ivec2 groups = tile * ivec2(gl_NumWorkGroups.yz) + ivec2(gl_WorkGroupID.yz);
    ivec2 at = groups * TILE + ivec2(gl_LocalInvocationID.xy);
    if (all(lessThan(at, imageSize(out_color_img)))) composite(at);
}

void main() { FOR_EACH_TILE(composite_tile) }

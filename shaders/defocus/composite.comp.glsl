// Composites a blurred layer that is smaller than the picture. The blur itself composites layers of
// full size.
//
// Inputs
//   layer_tx        rgb times coverage, a coverage, both blurred; inactive tiles are read as empty
//   with MIXED, for a layer whose larger size is already in out_color_img:
//   behind_tx       rgb of the layers behind; `share` is the weight of the smaller size
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

#ifdef MIXED
uniform sampler2D behind_tx;
uniform float share;

vec3 behind_at(ivec2 at) { return texelFetch(behind_tx, at, 0).rgb; }
vec3 cross_fade_at(ivec2 at, vec3 color) { return mix(imageLoad(out_color_img, at).rgb, color, share); }
#else
vec3 behind_at(ivec2 at) { return imageLoad(out_color_img, at).rgb; }
vec3 cross_fade_at(ivec2 at, vec3 color) { return color; }
#endif

void composite(ivec2 at) {
    vec3 color = composite_over(layer_at(at), behind_at(at)).rgb;
    imageStore(out_color_img, at, vec4(cross_fade_at(at, color), 1.0));
}

// Composites the pixels of a workgroup in a tile. With a reduction of 2, a tile stands for 2 x 2
// workgroups.
void composite_tile(ivec2 tile) {
    ivec2 groups = tile * ivec2(gl_NumWorkGroups.yz) + ivec2(gl_WorkGroupID.yz);
    ivec2 at = groups * TILE + ivec2(gl_LocalInvocationID.xy);
    if (all(lessThan(at, imageSize(out_color_img)))) composite(at);
}

void main() { FOR_EACH_TILE(composite_tile) }

// One sample more for the pixels of a band that are not done yet.
//
// Inputs
//   view_tx    rgb, one sample a pixel
//   done_tx    views after which a pixel was done, 0 where it is not; counts if `has_done`
//   first_row  of the band
//   is_first   nothing is in the sum yet
// In and out
//   sum_img    rgb, and the sum of the squares of the luminance that antialias_done looks at

#include "lib/antialias.lib.glsl"

layout(local_size_x = PIXEL_GROUP, local_size_y = PIXEL_GROUP) in;

uniform sampler2D view_tx;
uniform sampler2D done_tx;
uniform int first_row;
uniform bool is_first;
uniform bool has_done;
layout(rgba32f) uniform image2D sum_img;

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy) + ivec2(0, first_row);
    if (any(greaterThanEqual(at, imageSize(sum_img)))) return;
    if (has_done && texelFetch(done_tx, at, 0).r > 0.0) return;
    vec3 light = texelFetch(view_tx, at, 0).rgb;
    vec4 sum = is_first ? vec4(0.0) : imageLoad(sum_img, at);
    imageStore(sum_img, at, sum + vec4(light, luminance(light) * luminance(light)));
}

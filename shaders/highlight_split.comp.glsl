// Takes out of the picture what is much brighter than its diffused surroundings. A short sum of
// exponentials shows a few per cent of ripple, and a few per cent of a lamp is brighter than the wall;
// so lamps are drawn as the discs they become (highlight_draw), light conserved.
//
// Inputs
//   color_tx          scene-linear rgb, a kept
//   surroundings_tx   diffused luminance, a pixel for 2 x 2
//   coc_tx            signed circle of confusion, pixels
// Outputs
//   out_low_img       what is diffused
//   out_high_img      rgb what was taken out, a signed coc

#include "lib/tone.lib.glsl"

layout(local_size_x = PIXEL_GROUP, local_size_y = PIXEL_GROUP) in;

uniform sampler2D color_tx;
uniform sampler2D surroundings_tx;
uniform sampler2D coc_tx;
layout(rgba32f) uniform writeonly image2D out_low_img;
layout(rgba32f) uniform writeonly image2D out_high_img;

#define TIMES_BRIGHTER 3.0
#define LEAST_LUMINANCE 0.25  // grain in the dark is no lamp
#define LEAST_COC_PX 0.25     // smaller discs are pixels,
#define WHOLE_COC_PX 0.75     // larger ones are drawn in full; in between by degrees

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(at, textureSize(color_tx, 0)))) return;
    vec4 x = texelFetch(color_tx, at, 0);
    float coc = texelFetch(coc_tx, at, 0).r;
    float limit = TIMES_BRIGHTER * texelFetch(surroundings_tx, at >> 1, 0).r + LEAST_LUMINANCE;
    float luminance = mean_of(x.rgb);
    float drawn = smoothstep(LEAST_COC_PX, WHOLE_COC_PX, abs(coc));
    float over = luminance > limit ? drawn * (1.0 - limit / luminance) : 0.0;
    imageStore(out_low_img, at, vec4(x.rgb - over * x.rgb, x.a));
    imageStore(out_high_img, at, vec4(over * x.rgb, coc));
}

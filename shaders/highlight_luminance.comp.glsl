// What a highlight's surroundings are measured in: mean of rgb, clipped, so that the lamp itself does
// not raise the level it is compared with.
//
// Input
//   color_tx          scene-linear rgb
// Output
//   out_luminance_img all channels the same, 0..1

#include "lib/tone.lib.glsl"

layout(local_size_x = 16, local_size_y = 16) in;

uniform sampler2D color_tx;
layout(rgba32f) uniform writeonly image2D out_luminance_img;

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(at, textureSize(color_tx, 0)))) return;
    imageStore(out_luminance_img, at, vec4(clamp(mean_of(texelFetch(color_tx, at, 0).rgb), 0.0, 1.0)));
}

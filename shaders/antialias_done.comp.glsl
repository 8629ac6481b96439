// Which pixels need no further samples: in them and in all around them those that there are differ
// so little that more of them would change nothing that can be seen.
//
// Input
//   sum_tx        see antialias_add
// Output
//   out_done_img  `views` where a pixel is done, else 0

#include "lib/antialias.lib.glsl"

layout(local_size_x = PIXEL_GROUP, local_size_y = PIXEL_GROUP) in;

uniform sampler2D sum_tx;
uniform float views;    // samples in each pixel
uniform float most;     // deviation of the mean that may stay, as a part of the light
uniform float darkest;  // what is added to the light for that, for the eye does not see in the dark
layout(r16f) uniform writeonly image2D out_done_img;

bool is_noisy(ivec2 at) {
    vec4 sum = texelFetch(sum_tx, at, 0) / views;
    float mean = luminance(sum.rgb), variance = max(sum.a - mean * mean, 0.0);
    return sqrt(variance / views) > most * (mean + darkest);
}

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy), size = imageSize(out_done_img);
    if (any(greaterThanEqual(at, size))) return;
    bool noisy = false;
    for (int i = 0; i < 9 && !noisy; ++i)
        noisy = is_noisy(clamp(at + ivec2(i % 3, i / 3) - 1, ivec2(0), size - 1));
    imageStore(out_done_img, at, vec4(noisy ? 0.0 : views));
}

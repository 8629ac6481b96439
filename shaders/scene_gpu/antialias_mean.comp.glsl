// Computes, for each pixel of a band of rows of the picture, the mean of its samples and how much they differ.
//
// Inputs
//   samples_tx      scene-linear rgb of the band, `across` x `across` samples a pixel
//   first_row       first row of the band
//   end_row         the row after its last one
// Outputs
//   mean_img        rgb mean of the samples, alpha 1
//   out_spread_img  r luminance of the mean plus `black_light`, g standard deviation of the samples' luminance

#include "lib/antialias.lib.glsl"  // luminance

layout(local_size_x = PIXEL_GROUP, local_size_y = PIXEL_GROUP) in;

uniform sampler2D samples_tx;
uniform int across;
uniform int first_row;
uniform int end_row;
uniform float black_light;  // light that counts as black: added to the luminance, as the eye sees little in the dark
writeonly uniform image2D mean_img;
layout(rg16f) uniform writeonly image2D out_spread_img;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy), at = pixel + ivec2(0, first_row);
    if (at.x >= imageSize(mean_img).x || at.y >= end_row) return;
    vec3 sum = vec3(0.0);
    float squares = 0.0, count = float(across * across);
    for (int i = 0; i < across * across; ++i) {
        vec3 light = texelFetch(samples_tx, across * pixel + ivec2(i % across, i / across), 0).rgb;
        sum += light;
        squares += luminance(light) * luminance(light);
    }
    vec3 mean = sum / count;
    float level = luminance(mean), variance = max(squares / count - level * level, 0.0);
    imageStore(mean_img, at, vec4(mean, 1.0));
    imageStore(out_spread_img, at, vec4(level + black_light, sqrt(variance), 0.0, 0.0));
}

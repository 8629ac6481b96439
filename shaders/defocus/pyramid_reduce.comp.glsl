// Computes a level of the pyramid from the level below it, with Burt and Adelson's 5 x 5 binomial filter at every
// second pixel. Pixel i of a level is at pixel 2^level * i of the picture. Levels lie side by side in one texture,
// without the picture itself.
//
// Input
//   source_tx    rgba of the level below, at `source_rect`: the picture, or the texture of the levels
// Output
//   out_img      rgba of this level, at `out_rect` in the texture of the levels

layout(local_size_x = PIXEL_GROUP, local_size_y = PIXEL_GROUP) in;

uniform sampler2D source_tx;
uniform ivec4 source_rect;  // corner and size of the level below
uniform ivec4 out_rect;     // those of this level
layout(rgba32f) uniform writeonly image2D out_img;

// Along each axis; what lies outside the level is left out, and the sum is divided by the weights used.
const float WEIGHTS[5] = float[](1.0, 4.0, 6.0, 4.0, 1.0);

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(at, out_rect.zw))) return;
    vec4 sum = vec4(0.0);
    float weight = 0.0;
    for (int y = 0; y < 5; ++y)
        for (int x = 0; x < 5; ++x) {
            ivec2 from = 2 * at + ivec2(x, y) - 2;
            if (any(lessThan(from, ivec2(0))) || any(greaterThanEqual(from, source_rect.zw))) continue;
            float w = WEIGHTS[x] * WEIGHTS[y];
            sum += w * texelFetch(source_tx, source_rect.xy + from, 0);
            weight += w;
        }
    imageStore(out_img, out_rect.xy + at, sum / weight);
}

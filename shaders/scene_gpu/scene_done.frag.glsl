// Covers the pixels that need no more samples, to prevent shading there.

#include "lib/samples.lib.glsl"

uniform sampler2D done_tx;  // 0 where a pixel is not done

void main() {
    if (texelFetch(done_tx, pixel_of(sample_place()), 0).r == 0.0) discard;
}

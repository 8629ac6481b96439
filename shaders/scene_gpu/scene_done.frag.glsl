// Covers the pixels that need no more samples with the nearest depth, so that nothing is shaded there. Other pixels are
// left as they are. Only depth is written.
//
// Input
//   done_tx   see antialias_done.comp.glsl

#include "lib/samples.lib.glsl"  // sample_position, pixel_of

uniform sampler2D done_tx;  // a texel for each pixel of the picture: 0 where it needs more samples

void main() {
    if (texelFetch(done_tx, pixel_of(sample_position()), 0).r == 0.0) discard;
}

// Covers the pixels that need no more samples with the nearest depth, so that nothing is shaded there. Other pixels are
// left as they are. Only depth is written.
//
// Input
//   done_tx   1 for a pixel of the picture that needs no more samples, else 0

#include "lib/samples.lib.glsl"  // sample_position, pixel_of

uniform sampler2D done_tx;

void main() {
    if (texelFetch(done_tx, pixel_of(sample_position()), 0).r == 0.0) discard;
}

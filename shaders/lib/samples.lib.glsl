// Maps samples, which are drawn as separate pixels of a larger picture, to the pixels that they belong to. The position
// of a sample is that of its pixel in the larger picture.

uniform int samples_across;  // samples of a pixel, each way
uniform int first_row;       // first row of the picture that is drawn
uniform int rows_above;      // rows of other draws above it in the texture

// The position of the sample that this fragment draws.
ivec2 sample_position() { return ivec2(gl_FragCoord.xy) - ivec2(0, rows_above); }
// The pixel of the picture to which a sample belongs.
ivec2 pixel_of(ivec2 position) { return position / samples_across + ivec2(0, first_row); }

// Index of a sample within its pixel.
int number_of(ivec2 position) {
    ivec2 within = ivec2(position.x % samples_across, position.y % samples_across);
    return within.y * samples_across + within.x;
}

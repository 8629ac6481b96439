// The constant c of a compact Laplacian, with which small discs of the blur get the right shape.
//
// The blur of lib/blur_system.lib.glsl solves (1 + kappa d^2 L) y = x along each line of pixels:
//   x, y    the line before and after the blur
//   d       diameter of the disc, pixels
//   kappa   a constant of the kernel, which gives the blur the variance of the disc
//   L       the negative second difference: (L y)_i = 2 y_i - y_(i-1) - y_(i+1)
//
// At a frequency of w radians a pixel, L multiplies by 2 - 2 cos(w). This approximates w^2 but is too small at high
// frequencies, which makes small discs too pointed (at d = 4 px the radius at half height is 17 % short).
// L / (1 - c L) in place of L follows w^2 much further, preserves the variance, and the system to solve stays
// tridiagonal:
//
//   (1 + kappa d^2 L / (1 - c L))^-1 = (1 + (kappa d^2 - c) L)^-1 (1 - c L)
//
// c = 1/12 would be exact to fourth order (Numerov); 0.1 is closer over all frequencies. Towards focus c falls
// smoothly with d^2: sharp pixels exchange nothing, and a slow focus pull shows no bend.

uniform float compact_c;  // c of large discs; 0 for the plain Laplacian

#define COMPACT_FROM_PX_2 16.0  // d^2 from which c has its full value

// The constant c for a squared diameter d^2, pixels^2.
float compact_at(float d_2) {
    float relative_square = min(d_2 / COMPACT_FROM_PX_2, 1.0);
    return compact_c * relative_square * (2.0 - relative_square);
}

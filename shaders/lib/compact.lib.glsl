// A compact Laplacian. On the pixel grid 2 - 2 cos(w) stands for w^2 and falls short of it at high
// frequencies, which makes small discs too pointed (at d = 4 px the radius at half height would be 17 % short).
// L / (1 - c L) follows w^2 much further, keeps the variance, and its inverse step stays tridiagonal:
//
//   (1 + kappa d^2 L / (1 - c L))^-1 = (1 + (kappa d^2 - c) L)^-1 (1 - c L)
//
// c = 1/12 would be exact to fourth order (Numerov); 0.1 is nearer over all frequencies. Towards
// focus c fades with d^2, so that nothing flows where nothing did.

uniform float compact_c;  // 0 for the plain Laplacian

#define COMPACT_FROM_PX_2 16.0  // d^2 from which c is whole

float compact_at(float d_2) { return compact_c * min(d_2 / COMPACT_FROM_PX_2, 1.0); }

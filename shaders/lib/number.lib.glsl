// One arithmetic for real and complex kernels.
//
//   Num    a coefficient: float, or vec2 (real, imaginary)
//   Value  what is diffused, four channels: vec4, or mat2x4 (column 0 real, column 1 imaginary)
//
// Both take + and float *; what differs is written below. COMPLEX is set by the program.

#ifndef COMPLEX
#define COMPLEX 1
#endif

#if COMPLEX
#define Num vec2
#define Value mat2x4
#define ZERO_NUM vec2(0.0)
#define ZERO_VALUE mat2x4(0.0)

Num num(float a) { return vec2(a, 0.0); }
Num mul(Num a, Num b) { return vec2(a.x * b.x - a.y * b.y, a.x * b.y + a.y * b.x); }
Num inverted(Num a) { return vec2(a.x, -a.y) / dot(a, a); }
Value value(vec4 a) { return mat2x4(a, vec4(0.0)); }
Value mul(Num a, Value v) { return mat2x4(a.x * v[0] - a.y * v[1], a.x * v[1] + a.y * v[0]); }
vec4 real_part(Value v) { return v[0]; }
vec4 real_of_product(Num a, Value v) { return a.x * v[0] - a.y * v[1]; }
#else
#define Num float
#define Value vec4
#define ZERO_NUM 0.0
#define ZERO_VALUE vec4(0.0)

Num num(float a) { return a; }
Num mul(Num a, Num b) { return a * b; }
Num inverted(Num a) { return 1.0 / a; }
Value value(vec4 a) { return a; }
Value mul(Num a, Value v) { return a * v; }
vec4 real_part(Value v) { return v; }
vec4 real_of_product(Num a, Value v) { return a * v; }
#endif

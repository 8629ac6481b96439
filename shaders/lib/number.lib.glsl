// One arithmetic for real and complex kernels, so that the code that solves a line serves both. COMPLEX, set by the
// program, selects one of them.
//
//   Num       a coefficient: a float, or a vec2 (real, imaginary) if COMPLEX
//   Channels  the channels that are solved together: four, or two if PARTS is 2: two invocations then solve two channels each
//   Value     what is diffused: Channels, or a matrix (column 0 real, column 1 imaginary) if COMPLEX
//
// All three support + and multiplication by a float with GLSL's operators; the other operations are below.

#ifndef COMPLEX
#define COMPLEX 1
#endif

#ifndef PARTS
#define PARTS 1
#endif

#if PARTS == 1
#define Channels vec4
#define ComplexValue mat2x4
#else
#define Channels vec2
#define ComplexValue mat2
#endif

#if COMPLEX
#define Num vec2
#define Value ComplexValue
#define ZERO_NUM vec2(0.0)
#define ZERO_VALUE Value(0.0)

Num num(float a) { return vec2(a, 0.0); }
Num mul(Num a, Num b) { return vec2(a.x * b.x - a.y * b.y, a.x * b.y + a.y * b.x); }
Num inverted(Num a) { return vec2(a.x, -a.y) / dot(a, a); }
Num root(Num a) {  // the root with a positive real part, without cancellation
    float larger = sqrt(0.5 * (length(a) + abs(a.x))), smaller = 0.5 * abs(a.y) / max(larger, 1e-30);
    vec2 whole = a.x < 0.0 ? vec2(smaller, larger) : vec2(larger, smaller);
    return vec2(whole.x, a.y < 0.0 ? -whole.y : whole.y);
}
Value value(Channels a) { return Value(a, Channels(0.0)); }
Value mul(Num a, Value v) { return Value(a.x * v[0] - a.y * v[1], a.x * v[1] + a.y * v[0]); }
Channels real_part(Value v) { return v[0]; }
Channels real_of_product(Num a, Value v) { return a.x * v[0] - a.y * v[1]; }
#else
#define Num float
#define Value Channels
#define ZERO_NUM 0.0
#define ZERO_VALUE Channels(0.0)

Num num(float a) { return a; }
Num mul(Num a, Num b) { return a * b; }
Num inverted(Num a) { return 1.0 / a; }
Num root(Num a) { return sqrt(a); }
Value value(Channels a) { return a; }
Value mul(Num a, Value v) { return a * v; }
Channels real_part(Value v) { return v; }
Channels real_of_product(Num a, Value v) { return a * v; }
#endif

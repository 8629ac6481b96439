// The network that blurs a line: a chain of pixels, each with a specific heat of 1 to ground and a
// conductance to its neighbours, kappa * min(d, d')^2 with d the diameter of the circle of confusion
// along this axis. Where either neighbour is in focus nothing flows.
// (Kass, Lefohn, Owens 2006, section 3; kappa complex: a rational function of the line's Laplacian.)
//
// Rows produce one image for each pole of the columns; the columns solve these and add the real parts:
//   z_b = sum_a M_ab / m_b (1 + kappa_a L_x)^-1 x      y = Re sum_b m_b (1 + kappa_b L_y)^-1 z_b
// with m_b = sum_a M_ab, so that a uniform picture stays exactly uniform, also between rows and columns.
//
// Inputs
//   coc_tx      signed circle of confusion, diameter in pixels
//   source_tx   rows only: rgb scene-linear times coverage, a coverage
//   color_tx    columns only: the colour of pixels that are exactly in focus
//   poles_tx    columns only: output of the rows; one layer a pole, eight halves in its four words,
//               if HALF_POLES, else floats, two layers a pole (real, imaginary) if COMPLEX
// Outputs
//   out_poles_img (rows)    color_img (columns; with is_over also read: what the blurred picture covers)
//
// The functions of this file keep the contract of shaders/README.md.

#include "lib/compact.lib.glsl"
#include "lib/number.lib.glsl"
#include "lib/line.lib.glsl"
#include "lib/strips.lib.glsl"

uniform sampler2D coc_tx;
uniform float axis_scale;      // diameter along this axis / coc_tx, from the aperture's spread and the pixel aspect
uniform float least_px;        // smallest diameter: pixels with a smaller coc get this one
uniform float resampled_px_2;  // blur that reducing and enlarging a smaller picture adds by themselves
uniform Num kappa[POLES];

#ifdef ROWS
uniform Num mix_weights[POLES * POLES];  // M_ab / m_b
uniform sampler2D source_tx;
#ifdef HALF_POLES
layout(rgba32ui) uniform writeonly uimage2DArray out_poles_img;
#else
layout(rgba32f) uniform writeonly image2DArray out_poles_img;
#endif
#else
#ifdef HALF_POLES
uniform usampler2DArray poles_tx;
#else
uniform sampler2DArray poles_tx;
#endif
uniform sampler2D color_tx;
uniform Num sum_weights[POLES];  // m_b
layout(rgba32f) uniform image2D color_img;
uniform bool is_over;
#include "lib/over.lib.glsl"

// A pixel exactly in focus keeps its value bit for bit: the weights sum to 1 only up to rounding.
void store_color(ivec2 at, vec4 y, bool is_in_focus) {
    if (is_in_focus) y = texelFetch(color_tx, at, 0);
    if (is_over) y = composite_over(y, imageLoad(color_img, at).rgb);
    imageStore(color_img, at, y);
}
#endif

#ifdef SHAPED
// An opening that is not an ellipse is diffused as a disc of equal variance, which differs between front
// and back of the focus and towards the corners of the picture.
uniform vec2 side_variances;   // in front of the focus and behind it, relative to a round disc
uniform vec2 field_middle_px;
uniform vec2 field_per_px;     // 1 / distance from the middle to a corner, in pixels across and down
uniform vec2 field_variances[FIELD_STEPS];  // radially and tangentially, in even steps, relative to the centre

// Variance of the opening along this axis at a pixel, relative to that of a round disc.
float shape_variance(ivec2 at, float coc) {
    vec2 field = (vec2(at) + 0.5 - field_middle_px) * field_per_px;
    float step = min(length(field), 1.0) * float(FIELD_STEPS - 1);
    int low = min(int(step), FIELD_STEPS - 2);
    vec2 here = mix(field_variances[low], field_variances[low + 1], step - float(low));
    vec2 outwards = field * field / max(dot(field, field), 1e-12);
#ifdef ROWS
    float outward_share = outwards.x;
#else
    float outward_share = outwards.y;
#endif
    return mix(here.y, here.x, outward_share) * (coc < 0.0 ? side_variances.x : side_variances.y);
}
#endif

// Square of the diameter along this axis at a pixel, without the blur of resampling.
float diameter_2_at(ivec2 at) {
    float coc = texelFetch(coc_tx, at, 0).r;
    float diameter = max(abs(coc), least_px) * axis_scale;
#ifdef SHAPED
    return max(diameter * diameter * shape_variance(at, coc) - resampled_px_2, 0.0);
#else
    return max(diameter * diameter - resampled_px_2, 0.0);
#endif
}

// Half floats halve the memory traffic between rows and columns. Values are rounded here, because drivers
// differ (Mesa truncates, which darkens), and limited, because an infinity would spread.
vec4 round_to_half(vec4 v) {
    v = uintBitsToFloat(floatBitsToUint(v) + 0x1000u & 0xffffe000u);
    return clamp(v, -65504.0, 65504.0);
}

uvec2 halves_of(vec4 v) {
    v = round_to_half(v);
    return uvec2(packHalf2x16(v.xy), packHalf2x16(v.zw));
}

vec4 floats_of(uvec2 v) { return vec4(unpackHalf2x16(v.x), unpackHalf2x16(v.y)); }

Num flow(int pole, float d_2) { return kappa[pole] * d_2 - num(compact_at(d_2)); }

// The heat capacity, at the last pixel of a line, of all pixels beyond it: the pixel at the border is repeated without
// end. It solves Y = b (1 + Y) / (1 + b + Y), because one more repeated pixel changes nothing.
#define IS_REPEATED true
Num repeated_heat_of(int pole, float d_2) {
    Num b = flow(pole, d_2);
    return 2.0 * mul(b, inverted(num(1.0) + root(num(1.0) + 4.0 * b)));
}

#ifdef IN_PARTS
#include "lib/blur_parts.lib.glsl"
#else

#ifdef ROWS
struct Input {
    float d_2;
    vec4 x;
};

Input input_at(ivec2 at) { return Input(diameter_2_at(at), texelFetch(source_tx, at, 0)); }

struct Source {
    vec4 x;
};

Source source_of(Input before, Input here, Input after, float b_in, float b_out) {
    return Source(here.x + compact_at(b_in) * (before.x - here.x) + compact_at(b_out) * (after.x - here.x));
}

Value source(Source s, int pole) { return value(s.x); }

struct Output {
    Value z[POLES];
};

void clear_output(out Output o) {
    for (int k = 0; k < POLES; ++k) o.z[k] = ZERO_VALUE;
}

void add_pole(inout Output o, int pole, Value y) {
    for (int k = 0; k < POLES; ++k) o.z[k] += mul(mix_weights[pole * POLES + k], y);
}

void store(ivec2 at, Input here, Output o) {
    for (int k = 0; k < POLES; ++k) {
#if COMPLEX && defined HALF_POLES
        imageStore(out_poles_img, ivec3(in_strips(at), k), uvec4(halves_of(o.z[k][0]), halves_of(o.z[k][1])));
#elif COMPLEX
        imageStore(out_poles_img, ivec3(in_strips(at), 2 * k), o.z[k][0]);
        imageStore(out_poles_img, ivec3(in_strips(at), 2 * k + 1), o.z[k][1]);
#elif defined HALF_POLES
        imageStore(out_poles_img, ivec3(in_strips(at), k), uvec4(halves_of(o.z[k]), 0u, 0u));
#else
        imageStore(out_poles_img, ivec3(in_strips(at), k), o.z[k]);
#endif
    }
}

#else
struct Input {
    float d_2;
    Value z[POLES];
};

Value row_image(ivec2 at, int k) {
#if COMPLEX && defined HALF_POLES
    uvec4 v = texelFetch(poles_tx, ivec3(in_strips(at), k), 0);
    return Value(floats_of(v.xy), floats_of(v.zw));
#elif COMPLEX
    return Value(texelFetch(poles_tx, ivec3(in_strips(at), 2 * k), 0), texelFetch(poles_tx, ivec3(in_strips(at), 2 * k + 1), 0));
#elif defined HALF_POLES
    return floats_of(texelFetch(poles_tx, ivec3(in_strips(at), k), 0).xy);
#else
    return texelFetch(poles_tx, ivec3(in_strips(at), k), 0);
#endif
}

Input input_at(ivec2 at) {
    Input read;
    read.d_2 = diameter_2_at(at);
    for (int k = 0; k < POLES; ++k) read.z[k] = row_image(at, k);
    return read;
}

struct Source {
    Value z[POLES];
};

Source source_of(Input before, Input here, Input after, float b_in, float b_out) {
    float c_in = compact_at(b_in), c_out = compact_at(b_out);
    Source s;
    for (int k = 0; k < POLES; ++k)
        s.z[k] = here.z[k] + c_in * (before.z[k] - here.z[k]) + c_out * (after.z[k] - here.z[k]);
    return s;
}

Value source(Source s, int pole) { return s.z[pole]; }

struct Output {
    vec4 y;
};

void clear_output(out Output o) { o.y = vec4(0.0); }
void add_pole(inout Output o, int pole, Value y) { o.y += real_of_product(sum_weights[pole], y); }

void store(ivec2 at, Input here, Output o) { store_color(at, o.y, here.d_2 == 0.0); }
#endif

float conductance(Input a, Input b) { return min(a.d_2, b.d_2); }
float specific_heat(Input here) { return 1.0; }
Num repeated_heat(int pole, Input here) { return repeated_heat_of(pole, here.d_2); }
#endif

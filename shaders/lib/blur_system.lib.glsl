// The network that blurs a line: chain of pixels, each with a specific heat to ground and a
// conductance to its neighbours, kappa * min(d, d')^2 with d the diameter of the circle of confusion
// along this axis. Where either neighbour is in focus nothing flows.
// (Kass, Lefohn, Owens 2006, section 3; kappa complex: a rational function of the line's Laplacian.)
//
// Rows give one image a pole. Columns mix these with M and add the real parts:
//   y = Re sum_ab M_ab (1 + kappa_b L_y)^-1 (1 + kappa_a L_x)^-1 x
//
// Inputs
//   coc_tx      signed circle of confusion, diameter in pixels
//   source_tx   rows only: rgb scene-linear times coverage, a coverage (compact_source.comp.glsl)
//   color_tx    columns only: the same before it was made a source
//   poles_tx    columns only: one image a pole, two layers each (real, imaginary) if COMPLEX
// Outputs
//   out_poles_img (rows)    out_color_img (columns)

#include "lib/compact.lib.glsl"
#include "lib/number.lib.glsl"
#include "lib/each_pole.lib.glsl"
#include "lib/line.lib.glsl"

uniform sampler2D coc_tx;
uniform float axis_scale;  // squeeze and pixel aspect: diameter along this axis / coc_tx
uniform float least_px;    // pixels with a smaller coc are blurred by this
uniform Num kappa[POLES];

#define LAYERS_PER_POLE (1 + COMPLEX)

#define Node float
#define NODE_OUTSIDE 0.0
float node_at(ivec2 at) { return max(abs(texelFetch(coc_tx, at, 0).r), least_px) * axis_scale; }

float conductance(float d, float d_next) {
    float narrower = min(d, d_next);
    return narrower * narrower;
}

float specific_heat(float d) { return 1.0; }

Num flow(int pole, float d_2) { return kappa[pole] * d_2 - num(compact_at(d_2)); }

#ifdef ROWS
uniform sampler2D source_tx;
uniform writeonly image2DArray out_poles_img;

Value source(ivec2 at, int pole) { return value(texelFetch(source_tx, at, 0)); }

void sources(ivec2 at, out Value r[POLES]) {
    Value x = value(texelFetch(source_tx, at, 0));
    for (int p = 0; p < POLES; ++p) r[p] = x;
}

// Half storage halves what moves between rows and columns. Rounded here, because drivers differ (Mesa
// truncates, which darkens), and limited, because an infinity would spread.
vec4 stored(vec4 v) {
#ifdef HALF_POLES
    v = uintBitsToFloat(floatBitsToUint(v) + 0x1000u & 0xffffe000u);
    return clamp(v, -65504.0, 65504.0);
#else
    return v;
#endif
}

void store_pole(ivec2 at, int pole, Value y) {
#if COMPLEX
    imageStore(out_poles_img, ivec3(at, 2 * pole), stored(y[0]));
    imageStore(out_poles_img, ivec3(at, 2 * pole + 1), stored(y[1]));
#else
    imageStore(out_poles_img, ivec3(at, pole), stored(y));
#endif
}

#else
uniform sampler2DArray poles_tx;
uniform sampler2D color_tx;
uniform Num mix_weights[POLES * POLES];  // M, symmetric
uniform writeonly image2D out_color_img;

Value row_image(ivec2 at, int pole) {
#if COMPLEX
    return Value(texelFetch(poles_tx, ivec3(at, 2 * pole), 0),
                 texelFetch(poles_tx, ivec3(at, 2 * pole + 1), 0));
#else
    return texelFetch(poles_tx, ivec3(at, pole), 0);
#endif
}

Value source(ivec2 at, int pole) {
    Value r = ZERO_VALUE;
#define ADD_ROW_IMAGE(a) r += mul(mix_weights[a * POLES + pole], row_image(at, a));
    EACH_POLE(ADD_ROW_IMAGE)
    return r;
}

void mix_row_image(Value row, int a, inout Value r[POLES]) {
    for (int p = 0; p < POLES; ++p) r[p] += mul(mix_weights[a * POLES + p], row);
}

void sources(ivec2 at, out Value r[POLES]) {
    for (int p = 0; p < POLES; ++p) r[p] = ZERO_VALUE;
#define MIX_ROW_IMAGE(a) mix_row_image(row_image(at, a), a, r);
    EACH_POLE(MIX_ROW_IMAGE)
}

// What is exactly in focus keeps its value bit for bit: the weights sum to 1 only up to rounding.
void store_sum(ivec2 at, vec4 y) {
    if (node_at(at) == 0.0) y = texelFetch(color_tx, at, 0);
    imageStore(out_color_img, at, y);
}
#endif

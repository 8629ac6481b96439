// The network that extends a layer's circle of confusion beyond its content, so that what it covers
// spreads with its own blur: specific heat only where something is known, conduction only where
// something is not. What it carries is the diameter times how far it is known, and that by itself; the
// second divides the first at the end. (Kass, Lefohn, Owens 2006, section 4: blurring underneath.)
//
// Rows extend the content; columns extend that, trusting what rows reached less than content, so that
// also what lies diagonally from a corner is reached.
//
// Inputs
//   state_tx       r diameter |coc|, g how far the layer has content, 0..1
//   rows_tx        columns only: what the rows gave
// Outputs
//   out_rows_img (rows)    r diameter times knowledge, g knowledge
//   out_coc_img (columns)  diameter everywhere

#include "lib/number.lib.glsl"
#include "lib/line.lib.glsl"

uniform sampler2D state_tx;
uniform Num kappa[POLES];

#define FILL_CONDUCTANCE 64.0  // large: the extension is flat over tens of pixels
#define FILL_LEAK 1e-3         // specific heat of an empty pixel: the nearer edge counts more
#define ROW_TRUST 0.1          // small: neighbouring rows that reached apart are smoothed together

#define Node float  // how far the pixel is known, 0..1
#define NODE_OUTSIDE 1.0
float conductance(float known, float next) { return (1.0 - min(known, next)) * FILL_CONDUCTANCE; }
float specific_heat(float known) { return known + FILL_LEAK; }
Num flow(int pole, float conductance) { return kappa[pole] * conductance; }

#ifdef ROWS
vec2 known_at(ivec2 at) {
    vec2 state = texelFetch(state_tx, at, 0).rg;
    return vec2(state.r * state.g, state.g);
}
#else
uniform sampler2D rows_tx;
vec2 known_at(ivec2 at) {
    vec2 state = texelFetch(state_tx, at, 0).rg, rows = texelFetch(rows_tx, at, 0).rg;
    return mix(ROW_TRUST * rows, vec2(state.r, 1.0), state.g);
}
#endif

float node_at(ivec2 at) { return known_at(at).g; }
Value source(ivec2 at, int pole) { return value(vec4(known_at(at), 0.0, 0.0)); }
void sources(ivec2 at, out Value r[POLES]) { r[0] = source(at, 0); }

#ifdef ROWS
layout(rg32f) uniform writeonly image2D out_rows_img;
void store_pole(ivec2 at, int pole, Value y) { imageStore(out_rows_img, at, real_part(y)); }
#else
layout(r32f) uniform writeonly image2D out_coc_img;
void store_sum(ivec2 at, vec4 y) {
    vec2 state = texelFetch(state_tx, at, 0).rg;
    imageStore(out_coc_img, at, vec4(mix(y.r / max(y.g, 1e-8), state.r, state.g)));
}
#endif

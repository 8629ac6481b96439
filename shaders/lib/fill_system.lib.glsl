// The network that extends a layer's circle of confusion beyond its content, so that what it covers
// spreads with its own blur: specific heat only where there is content, conduction only between
// pixels of which one is empty. Rows and columns are solved apart and added; the diffused content
// mask divides the diffused diameter. (Kass, Lefohn, Owens 2006, section 4: blurring underneath.)
//
// Inputs
//   state_tx       r diameter |coc|, g how far the layer has content, 0..1
//   rows_tx        columns only: what the rows gave
// Outputs
//   out_rows_img (rows)    r diameter times mask, g mask, diffused
//   out_coc_img (columns)  diameter everywhere

#include "lib/number.lib.glsl"
#include "lib/line.lib.glsl"

uniform sampler2D state_tx;
uniform Num kappa[POLES];

#define FILL_CONDUCTANCE 64.0  // large: the extension is flat over tens of pixels
#define FILL_LEAK 1e-3         // specific heat of an empty pixel: the nearer edge counts more

#define Node float
#define NODE_OUTSIDE 1.0
float node_at(ivec2 at) { return texelFetch(state_tx, at, 0).g; }
float conductance(float content, float next) {
    return (1.0 - min(content, next)) * FILL_CONDUCTANCE;
}
float specific_heat(float content) { return content + FILL_LEAK; }
Num flow(int pole, float conductance) { return kappa[pole] * conductance; }

Value source(ivec2 at, int pole) {
    vec2 state = texelFetch(state_tx, at, 0).rg;
    return value(vec4(state.r * state.g, state.g, 0.0, 0.0));
}
void sources(ivec2 at, out Value r[POLES]) { r[0] = source(at, 0); }

#ifdef ROWS
layout(rg32f) uniform writeonly image2D out_rows_img;
void store_pole(ivec2 at, int pole, Value y) { imageStore(out_rows_img, at, real_part(y)); }
#else
uniform sampler2D rows_tx;
layout(r32f) uniform writeonly image2D out_coc_img;
void store_sum(ivec2 at, vec4 y) {
    vec2 state = texelFetch(state_tx, at, 0).rg;
    vec2 both = y.rg + texelFetch(rows_tx, at, 0).rg;
    float diameter = mix(both.r / max(both.g, 1e-8), state.r, state.g);
    imageStore(out_coc_img, at, vec4(diameter));
}
#endif

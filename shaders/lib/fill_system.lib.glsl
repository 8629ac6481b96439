// The network of heat that extends the circle of confusion (coc) of a layer beyond the layer's content, so that the
// content spreads with its own blur. (Kass, Lefohn, Owens 2006, section 4: blurring underneath.)
//
//   content   share of a pixel that belongs to the layer, 0..1; the diameter of the coc is known there
//   known     what enters the network outside the content: a diameter times its weight, and the weight
//   diffused  what enters it inside the content alone: the diameter times the content
//
// Outside the content: a pixel has specific heat only where the diameter is known, and conduction only where it is
// not. The network diffuses the diameter times its weight, and the weight; dividing the two gives the diameter.
//
// Inside the content the diameter diffuses as color will. At a silhouette within the layer this change
// is amplified, but only towards the nearer surface's diameter, because the nearer surface's blur is
// visible on both sides. Otherwise a nearer surface with more blur would end hard in front of the other, and one
// with less blur would glow into it.
//
// Rows extend the content first. Columns then extend the result of the rows, with less weight than content. This
// also reaches pixels diagonally off a corner.
//
// Inputs
//   state_tx       r diameter |coc|, g content, 0..1
//   axis_scale     by which the diameters of state_tx are multiplied, to have those along this axis
//   is_near        columns only: nearer surfaces are blurred more, not less
//   rows_diameter_buf, rows_weight_buf   columns only: the outputs of the rows
// Outputs
//   rows_diameter_buf   rows only: diameter times weight; inside the content the diffused diameter
//   rows_weight_buf     rows only: the weight
//   out_coc_img         columns only: the diameter |coc|, everywhere

// The functions of this file keep the contract of shaders/README.md.

#include "lib/number.lib.glsl"  // Num, Value, ZERO_NUM, value, real_part
#include "lib/line.lib.glsl"  // for the strategy that solves this system
#include "lib/strips.lib.glsl"  // index_in_buffer

uniform sampler2D state_tx;
uniform float axis_scale;
uniform Num kappa[POLES];

#define FILL_CONDUCTANCE 64.0  // large, so that the extension is flat over tens of pixels
#define FILL_LEAK 1e-3         // specific heat of a pixel without content; it gives the nearer edge more weight
#define ROW_TRUST 0.1          // weight of the rows' result; small, because it is to be smoothed from row to row

#define RIM_CONDUCTANCE (1.0 / 32.0)  // times diameter^2, so that diffusion reaches as far as the disc is wide
// Factors on the change by diffusion. At a silhouette diffusion reaches the mean of both sides; twice this change
// reaches the diameter of the nearer surface.
#define RIM_GAIN_FAR 2.5    // if nearer surfaces are blurred less
#define RIM_GAIN_NEAR 2.0   // if nearer surfaces are blurred more
#define RIM_SLACK_NEAR 0.03 // share of the diameter: smaller changes are the slope of a round surface
#define RIM_LEAST 0.6       // least factor by which the diameter changes, and 1 / the largest; spares texture

// What is read of one pixel. For rows `known` is the content; for columns it also has the rows' result.
struct Input {
    vec2 state;  // r diameter, g content 0..1
    vec2 known;  // r diameter times weight, g weight
    float diffused;
};

// Diameter along this axis, less where content is partial.
float along_axis(Input a) { return a.state.r * sqrt(a.state.g) * axis_scale; }

// Conductance inside the content.
float rim_conductance(Input a, Input b) {
    float narrower = min(along_axis(a), along_axis(b));
    return RIM_CONDUCTANCE * narrower * narrower;
}

float conductance(Input a, Input b) {
    return (1.0 - min(a.known.g, b.known.g)) * FILL_CONDUCTANCE + rim_conductance(a, b);
}

float specific_heat(Input here) { return here.known.g + FILL_LEAK; }
Num flow(int pole, float conductance) { return kappa[pole] * conductance; }

#define IS_REPEATED false
Num repeated_heat(int pole, Input here) { return ZERO_NUM; }

#ifdef ROWS
Input input_at(ivec2 at) {
    vec2 state = texelFetch(state_tx, at, 0).rg;
    return Input(state, vec2(state.r * state.g, state.g), state.r * state.g);
}
#else
layout(std430) readonly buffer rows_diameter_block { float rows_diameter_buf[]; };
layout(std430) readonly buffer rows_weight_block { float rows_weight_buf[]; };
uniform bool is_near;

// The rows' result at a pixel: diameter times weight, and weight.
vec2 rows_at(ivec2 at) {
    int index = index_in_buffer(at);
    return vec2(rows_diameter_buf[index], rows_weight_buf[index]);
}

Input input_at(ivec2 at) {
    vec2 state = texelFetch(state_tx, at, 0).rg, rows = rows_at(at);
    vec2 known = mix(ROW_TRUST * rows, vec2(state.r, 1.0), state.g);
    return Input(state, known, state.g * rows.r / max(rows.g, 1e-8));
}

// The diameter, moved towards that of a nearer surface by its diffused value.
float move_to_nearer(float diameter, float diffused) {
    float change = diffused - diameter;
    float step = is_near ? RIM_GAIN_NEAR * max(change - RIM_SLACK_NEAR * diameter, 0.0)
                         : RIM_GAIN_FAR * min(change, 0.0);
    return clamp(diameter + step, RIM_LEAST * diameter, diameter / RIM_LEAST);
}
#endif

struct Source {
    vec4 x;
};

// The right-hand side of a pixel: x known diameter times weight, y its weight, z diffused, w its weight. To x it adds
// back what flows to neighbors inside the content, because the extension must not diffuse there.
Source source_of(Input before, Input here, Input after, float b_in, float b_out) {
    float returned_flow = 0.0;
    if (b_in > 0.0) returned_flow += rim_conductance(before, here) * (here.state.r - before.state.r);
    if (b_out > 0.0) returned_flow += rim_conductance(here, after) * (here.state.r - after.state.r);
    return Source(vec4(here.known.r + returned_flow, here.known.g, here.diffused, here.state.g));
}

Value source(Source s, int pole) { return value(s.x); }

struct Output {
    vec4 y;
};

void clear_output(out Output o) { o.y = vec4(0.0); }
void add_pole(inout Output o, int pole, Value y) { o.y += real_part(y); }

#ifdef ROWS
layout(std430) writeonly buffer rows_diameter_block { float rows_diameter_buf[]; };
layout(std430) writeonly buffer rows_weight_block { float rows_weight_buf[]; };
void store(ivec2 at, Input here, Output o) {
    int index = index_in_buffer(at);
    rows_diameter_buf[index] = mix(o.y.r, o.y.b, here.state.g);
    rows_weight_buf[index] = o.y.g;
}
#else
layout(r32f) uniform writeonly image2D out_coc_img;
void store(ivec2 at, Input here, Output o) {
    vec2 state = here.state, outside_inside = o.y.rb / max(o.y.ga, 1e-8);  // diameters
    imageStore(out_coc_img, at, vec4(mix(outside_inside.x, move_to_nearer(state.r, outside_inside.y), state.g)));
}
#endif

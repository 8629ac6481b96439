// The network that extends a layer's circle of confusion beyond its content, so that what it covers
// spreads with its own blur: specific heat only where something is known, conduction only where
// something is not. What it carries is the diameter times how far it is known, and that by itself; the
// second divides the first at the end. (Kass, Lefohn, Owens 2006, section 4: blurring underneath.)
//
// Inside the content the diameter diffuses as colour will. Where it changes that way, at a silhouette
// within the layer, it is drawn on towards the nearer surface's, never the other way: there the nearer
// surface's blur is seen on both sides. Left alone, a nearer surface that is blurred more ends hard
// before the other, and one that is blurred less glows into it.
//
// Rows extend the content; columns extend that, trusting what rows reached less than content, so that
// also what lies diagonally from a corner is reached.
//
// Inputs
//   state_tx       r diameter |coc|, g how far the layer has content, 0..1
//   rows_tx        columns only: what the rows gave
//   axis_scale     diameter along this axis / that of state_tx
//   is_near        columns only: nearer is blurred more, not less
// Outputs
//   out_rows_img (rows)    r diameter times knowledge, g knowledge
//   out_coc_img (columns)  diameter everywhere

#include "lib/number.lib.glsl"
#include "lib/line.lib.glsl"

uniform sampler2D state_tx;
uniform float axis_scale;
uniform Num kappa[POLES];

#define FILL_CONDUCTANCE 64.0  // large: the extension is flat over tens of pixels
#define FILL_LEAK 1e-3         // specific heat of an empty pixel: the nearer edge counts more
#define ROW_TRUST 0.1          // small: neighbouring rows that reached apart are smoothed together

#define RIM_CONDUCTANCE (1.0 / 32.0)  // times diameter^2: diffused over the disc's own width
#define RIM_GAIN_FAR 2.5    // a straight silhouette has about the mean of both: twice the way is all of it
#define RIM_GAIN_NEAR 2.0
#define RIM_SLACK_NEAR 0.03 // of the diameter: less of a way is a round surface's own slope
#define RIM_LEAST 0.6       // of the diameter, and its inverse at most: texture keeps its own blur

#define Node vec2  // how far the pixel is known, 0..1; diameter along this axis as far as it is content
#define NODE_OUTSIDE vec2(1.0, 0.0)

float rim_conductance(Node a, Node b) {
    float narrower = min(a.y, b.y);
    return RIM_CONDUCTANCE * narrower * narrower;
}

float conductance(Node a, Node b) {
    return (1.0 - min(a.x, b.x)) * FILL_CONDUCTANCE + rim_conductance(a, b);
}

float specific_heat(Node node) { return node.x + FILL_LEAK; }
Num flow(int pole, float conductance) { return kappa[pole] * conductance; }

#ifdef ROWS
vec2 known_at(ivec2 at) {
    vec2 state = texelFetch(state_tx, at, 0).rg;
    return vec2(state.r * state.g, state.g);
}

float diffused_at(ivec2 at) { return known_at(at).r; }
#else
uniform sampler2D rows_tx;
uniform bool is_near;

vec2 known_at(ivec2 at) {
    vec2 state = texelFetch(state_tx, at, 0).rg, rows = texelFetch(rows_tx, at, 0).rg;
    return mix(ROW_TRUST * rows, vec2(state.r, 1.0), state.g);
}

float diffused_at(ivec2 at) {
    vec2 rows = texelFetch(rows_tx, at, 0).rg;
    return mix(ROW_TRUST * rows.r, rows.r / max(rows.g, 1e-8), texelFetch(state_tx, at, 0).g);
}

float drawn_nearer(float diameter, float diffused) {
    float way = diffused - diameter;
    float step = is_near ? RIM_GAIN_NEAR * max(way - RIM_SLACK_NEAR * diameter, 0.0)
                         : RIM_GAIN_FAR * min(way, 0.0);
    return clamp(diameter + step, RIM_LEAST * diameter, diameter / RIM_LEAST);
}
#endif

Node node_at(ivec2 at) {
    vec2 state = texelFetch(state_tx, at, 0).rg;
    return Node(known_at(at).g, state.r * sqrt(state.g) * axis_scale);
}

// What flows away to a neighbour inside the content, given back: the extension knows no diffusion.
float given_back(ivec2 at, int step) {
    ivec2 beside = at + step * axis;
    int i = beside.x * axis.x + beside.y * axis.y;
    if (i < 0 || i >= line_length) return 0.0;
    float fall = texelFetch(state_tx, at, 0).r - texelFetch(state_tx, beside, 0).r;
    return rim_conductance(node_at(at), node_at(beside)) * fall;
}

Value source(ivec2 at, int pole) {
    vec2 known = known_at(at);
    known.r += given_back(at, -1) + given_back(at, 1);
    return value(vec4(known, diffused_at(at), 0.0));
}

void sources(ivec2 at, out Value r[POLES]) { r[0] = source(at, 0); }

#ifdef ROWS
layout(rg32f) uniform writeonly image2D out_rows_img;
void store_pole(ivec2 at, int pole, Value y) {
    vec4 row = real_part(y);
    row.r = mix(row.r, row.b, texelFetch(state_tx, at, 0).g);
    imageStore(out_rows_img, at, row);
}
#else
layout(r32f) uniform writeonly image2D out_coc_img;
void store_sum(ivec2 at, vec4 y) {
    vec2 state = texelFetch(state_tx, at, 0).rg, means = y.rb / max(y.g, 1e-8);
    imageStore(out_coc_img, at, vec4(mix(means.r, drawn_nearer(state.r, means.g), state.g)));
}
#endif

// The network of heat that finds how steady the rows and columns of a layer are, for the guess of what wide things hide
// (hidden_fill.comp.glsl). A bar is steady along itself, also where many things hide it; a line that crosses bars is not.
//
// Along a line, every LINE_NODE pixels are a node. A node is a source of the weight, the light and the coverage of what is
// visible in it, and of their squares, which spread along the line. Quotients of the solution are means in which near
// nodes count most, and from these follows the variance around each node.
//
// Inputs
//   layer_tx     rgb times coverage, a coverage, in visible pixels
//   bits_buf     visible pixels (visible_bits.comp.glsl); with ENTERED all in active tiles
// Output
//   out_steadiness_img   r logarithm of the weight of the line, one texel for each node
//
// The functions of this file keep the contract of shaders/README.md.

#include "lib/number.lib.glsl"  // Num, Value, ZERO_NUM, value, real_part
#include "lib/line.lib.glsl"  // for the strategy that solves this system
#include "lib/entering.lib.glsl"  // free_share, coc_tx
#include "lib/strips.lib.glsl"  // for the strategy that solves this system
#include "lib/tone.lib.glsl"  // compress_light, mean_of
#include "lib/visible_bits.lib.glsl"  // visible_from

uniform Num kappa[POLES];      // square of the distance in nodes over which a line is measured
uniform ivec2 layer_size;      // in pixels of its own
uniform sampler2D layer_tx;
layout(r32f) uniform writeonly image2D out_steadiness_img;

#define SAMPLE_PX 4            // distance of the pixels of a node that are read
#define STEADY_VARIANCE 0.002  // variance of a line up to which it is steady
#define EMPTY_VARIANCE 0.1     // added for a line without content: that nothing is there does not go on as a bar does
#define STEADY_POWER 2.5       // the weight of a line falls with this power of its variance
#define LIGHT_SHARE 0.7        // weight of a difference of light relative to one of coverage
#define HIDDEN_FLOW 9.0        // conductance between hidden nodes, relative to visible ones

#ifdef ROWS
const ivec2 ALONG = ivec2(1, 0);
#else
const ivec2 ALONG = ivec2(0, 1);
#endif

// What is read of a node: x share that is visible; y compressed light times coverage, z coverage, w the sum of their
// squares; all times that share.
struct Input {
    vec4 visible;
};

Input input_at(ivec2 node) {
    vec4 sum = vec4(0.0);
    ivec2 first = node + ALONG * (LINE_NODE - 1) * node;
    uint visible = visible_from(ALONG.y, first, layer_size);
    for (int i = SAMPLE_PX / 2; i < LINE_NODE; i += SAMPLE_PX) {
        ivec2 at = first + ALONG * i;
        if ((visible >> i & 1u) == 0u) continue;
        vec4 layer = texelFetch(layer_tx, at, 0);
        float share = 1.0;
#ifdef ENTERED
        if (layer.a < 0.0) share = free_share(visibility(texelFetch(coc_tx, at, 0).r));
        if (layer.a < 0.0) layer.a = marked_cover(layer.a);
#endif
        layer = without_weight(layer);
        vec2 toned = vec2(LIGHT_SHARE * mean_of(compress_light(layer.rgb / max(layer.a, 1e-4))), 1.0) * layer.a;
        sum += share * vec4(1.0, toned, dot(toned, toned));
    }
    return Input(sum * (float(SAMPLE_PX) / float(LINE_NODE)));
}

float conductance(Input a, Input b) { return mix(HIDDEN_FLOW, 1.0, max(a.visible.x, b.visible.x)); }
float specific_heat(Input here) { return 1.0; }
Num flow(int pole, float conductance) { return kappa[pole] * conductance; }

#define IS_REPEATED false
Num repeated_heat(int pole, Input here) { return ZERO_NUM; }

struct Source {
    vec4 x;
};

Source source_of(Input before, Input here, Input after, float b_in, float b_out) { return Source(here.visible); }
Value source(Source s, int pole) { return value(s.x); }

struct Output {
    vec4 y;
};

void clear_output(out Output o) { o.y = vec4(0.0); }
void add_pole(inout Output o, int pole, Value y) { o.y += real_part(y); }

void store(ivec2 node, Input here, Output o) {
    vec3 mean = o.y.yzw / max(o.y.x, 1e-30);
    float variance = max(mean.z - dot(mean.xy, mean.xy), 0.0), empty = 1.0 - mean.y;
    variance += EMPTY_VARIANCE * empty * empty;
    imageStore(out_steadiness_img, node, vec4(-STEADY_POWER * log(variance + STEADY_VARIANCE)));
}

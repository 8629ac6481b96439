// The network of heat that blurs a line of a picture by its circle of confusion (coc).
//
// The network is a chain of pixels. Each pixel has a specific heat of 1 to ground and a conductance to its
// neighbors, kappa * min(d, d')^2, where d and d' are the diameters of the coc of the two pixels along this axis.
// Where either of the two is in focus nothing flows. (Kass, Lefohn, Owens 2006, section 3. There kappa is real;
// with complex kappa the blur is a rational function of the line's Laplacian.)
//
// A kernel (render/defocus/kernels.py) consists of poles, one kappa each, and of mixing weights M_ab. L_x and L_y
// are the Laplacians along rows and columns, with the squared diameters as conductances. Rows produce one image z_b
// for each pole b of the columns from the picture x; the columns solve these and add the real parts to the result y:
//   z_b = sum_a M_ab / m_b (1 + kappa_a L_x)^-1 x      y = Re sum_b m_b (1 + kappa_b L_y)^-1 z_b
// with m_b = sum_a M_ab, so that a uniform picture stays exactly uniform, also between rows and columns.
//
// The Laplacian is the compact one of lib/compact.lib.glsl, with its constant c: `flow` returns kappa d^2 - c, and
// `source_of` returns (1 - c L) of its input.
//
// Inputs
//   coc_tx      signed coc, diameter in pixels
//   source_tx   rows only: rgb scene-linear times coverage, a coverage
//   color_tx    columns only: the color of pixels that are exactly in focus
//   poles_tx    columns only: the output of the rows. With HALF_POLES it has one layer a pole, with eight halves in
//               its four words. Otherwise it has floats, and two layers a pole (real, imaginary) if COMPLEX.
// Outputs
//   out_poles_img   rows only: the images z_b, stored as described for poles_tx
//   color_img       columns only: the result y. With is_over it is also read: the blurred picture is composited
//                   over it.
// In and out
//   picture_buf     with PACKED_PICTURE, in place of source_tx, color_tx and color_img: half floats of each pixel, row by
//                   row. A CPU writes them faster than an image.
//
// The functions of this file keep the contract of shaders/README.md.

#include "lib/compact.lib.glsl"  // compact_at
#include "lib/number.lib.glsl"  // COMPLEX, Num, Value, ZERO_VALUE, num, mul, inverted, root, value, real_of_product
#include "lib/line.lib.glsl"  // for the strategy that solves this system
#include "lib/strips.lib.glsl"  // in_strips
#include "lib/halves.lib.glsl"  // halves_of, floats_of

uniform sampler2D coc_tx;
uniform float axis_scale;      // diameter along this axis / that of coc_tx: the aperture's spread and the pixel aspect
uniform float least_px;        // smallest diameter: pixels with a smaller coc get this one
uniform float resampled_px_2;  // squared diameter of the blur that comes from reducing and enlarging a picture
uniform Num kappa[POLES];  // one for each pole of the kernel

#ifdef PACKED_PICTURE
layout(std430) buffer picture_block { uvec2 picture_buf[]; };

int index_in_picture(ivec2 at) { return at.y * textureSize(coc_tx, 0).x + at.x; }
#endif

#ifdef ROWS
uniform Num mix_weights[POLES * POLES];  // M_ab / m_b
#ifdef PACKED_PICTURE
vec4 source_at(ivec2 at) { return floats_of(picture_buf[index_in_picture(at)]); }
#else
uniform sampler2D source_tx;
vec4 source_at(ivec2 at) { return texelFetch(source_tx, at, 0); }
#endif
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
uniform Num sum_weights[POLES];  // m_b
#ifdef PACKED_PICTURE
// Writes a pixel of the result. A pixel exactly in focus keeps its value.
void store_color(ivec2 at, vec4 y, bool is_in_focus) {
    if (!is_in_focus) picture_buf[index_in_picture(at)] = halves_of(y);
}
#else
uniform sampler2D color_tx;
layout(rgba32f) uniform image2D color_img;
uniform bool is_over;  // composite over what color_img contains, instead of replacing it
#include "lib/over.lib.glsl"  // composite_over

// Writes a pixel of the result. A pixel exactly in focus keeps its value bit for bit, because the weights sum to 1
// only up to rounding.
void store_color(ivec2 at, vec4 y, bool is_in_focus) {
    if (is_in_focus) y = texelFetch(color_tx, at, 0);
    if (is_over) y = composite_over(y, imageLoad(color_img, at).rgb);
    imageStore(color_img, at, y);
}
#endif
#endif

#ifdef SHAPED
// An opening that is not an ellipse is diffused as a disc of equal variance, which differs between front
// and back of the focus and towards the corners of the picture.
uniform vec2 side_variances;   // in front of the focus and behind it, relative to a round disc
uniform vec2 field_middle_px;
uniform vec2 field_per_px;     // 1 / distance from the middle to a corner, in pixels across and down
uniform vec2 field_variances[FIELD_STEPS];  // radially and tangentially, in even steps, relative to the center

// Variance of the opening along this axis at a pixel, relative to that of a round disc. The field is the position
// relative to the middle of the picture, with a length of 1 at the corners.
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

// Conductance between two pixels in the network of a pole; `d_2` is the smaller squared diameter of the two.
Num flow(int pole, float d_2) { return kappa[pole] * d_2 - num(compact_at(d_2)); }

// The heat capacity, at the last pixel of a line, of all pixels beyond it: the pixel at the border is repeated without
// end. With b the flow between repeated pixels, it is the Y that solves Y = b (1 + Y) / (1 + b + Y), because one more
// repeated pixel changes nothing.
#define IS_REPEATED true
Num repeated_heat_of(int pole, float d_2) {
    Num b = flow(pole, d_2);
    return 2.0 * mul(b, inverted(num(1.0) + root(num(1.0) + 4.0 * b)));
}

#ifdef IN_PARTS
#include "lib/blur_parts.lib.glsl"  // for a strategy that defines IN_PARTS
#else

#ifdef ROWS
struct Input {
    float d_2;
    vec4 x;
};

Input input_at(ivec2 at) { return Input(diameter_2_at(at), source_at(at)); }

struct Source {
    vec4 x;
};

// (1 - c L) of the input; b_in and b_out are the smaller squared diameters towards the pixel before and after.
Source source_of(Input before, Input here, Input after, float b_in, float b_out) {
    return Source(here.x + compact_at(b_in) * (before.x - here.x) + compact_at(b_out) * (after.x - here.x));
}

Value source(Source s, int pole) { return value(s.x); }

// The images for the poles of the columns.
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

// Image z_k of the rows at a pixel.
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

// The blur of lib/blur_system.lib.glsl for a strategy whose invocations keep several pixels in
// registers (solve_partition.comp.glsl). Registers do not suffice for every pole of every pixel at once: the
// channels (red, green, blue, alpha) are solved in one or two PARTS, and data that differs by pole is read when that
// pole is solved. The symbols are those of lib/blur_system.lib.glsl.
//
// Rows keep the solutions of one part until all poles are solved and can be mixed, as halves with HALF_POLES.
//
// A texel between rows and columns contains:
//   HALF_POLES, one part    eight halves: all channels of one pole
//   HALF_POLES, two parts   eight halves: the channels of one part, for two successive poles. If the number of poles
//                           is odd, the texel of the last pole contains both of its parts instead.
//   without HALF_POLES      four floats of one pole

#define Link float  // square of the diameter along this axis; all that the conductances depend on

Link link_at(ivec2 at) { return diameter_2_at(at); }
float conductance(Link a, Link b) { return min(a, b); }
float specific_heat(Link here) { return 1.0; }
Num repeated_heat(int pole, Link here) { return repeated_heat_of(pole, here); }
// Packed: a Value as it is stored, of one pole and part. Texel: what a texture fetch returns.
#ifndef HALF_POLES
#define Packed Value
#define Texel vec4
Packed pack(Value v) { return v; }
Value unpack(Packed p) { return p; }
#elif COMPLEX && PARTS == 1
#define Packed uvec4
#define Texel uvec4
Packed pack(Value v) { return uvec4(halves_of(v[0]), halves_of(v[1])); }
Value unpack(Packed p) { return Value(floats_of(p.xy), floats_of(p.zw)); }
#else
#define Packed uvec2
#define Texel uvec4
Packed pack(Value v) { return halves_of(vec4(v)); }
Value unpack(Packed p) { return Value(floats_of(p)); }
#endif

#if defined HALF_POLES && PARTS == 2
#define POLES_PER_TEXEL 2
#else
#define POLES_PER_TEXEL 1
#endif
#define HAS_SINGLE_POLE (POLES % POLES_PER_TEXEL == 1)

// The texture layer that holds a part of a pole; with two poles a texel, `pole` is the first of the two. The two poles
// have two layers, one for each part; a last pole without a partner has a single layer for both parts.
int layer_of(int part, int pole) {
#if !defined HALF_POLES && COMPLEX
    return 2 * pole + part;
#else
    return POLES - pole < POLES_PER_TEXEL ? pole : pole + part;
#endif
}

#ifdef ROWS
struct Input {
    vec4 x;
};

struct Source {
    vec4 x;
};

Input input_at(ivec2 at, int part, int pole) { return Input(source_at(at)); }

Source source_of(Input before, Input here, Input after, float b_in, float b_out) {
    return Source(here.x + compact_at(b_in) * (before.x - here.x) + compact_at(b_out) * (after.x - here.x));
}

Value source(Source s, int part, int pole) {
#if PARTS == 2
    return value(part == 0 ? s.x.xy : s.x.zw);
#else
    return value(s.x);
#endif
}

// The solution of each pole of the rows, for one part.
struct Output {
    Packed z[POLES];
#if HAS_SINGLE_POLE
    Packed single;  // the first part of the last pole, mixed; kept until its second part is mixed
#endif
};

void clear_output(out Output o) {
    for (int k = 0; k < POLES; ++k) o.z[k] = Packed(0);
#if HAS_SINGLE_POLE
    o.single = Packed(0);
#endif
}

// Selects by comparison, because a varying index would move the array out of registers.
void add_pole(inout Output o, int part, int pole, Value y) {
    for (int k = 0; k < POLES; ++k)
        if (k == pole) o.z[k] = pack(y);
}

// The image for pole k of the columns: the solutions of all poles of the rows, mixed.
Packed mix_poles(Output o, int k) {
    Value sum = ZERO_VALUE;
    for (int a = 0; a < POLES; ++a) sum += mul(mix_weights[a * POLES + k], unpack(o.z[a]));
    return pack(sum);
}

void write_texel(ivec2 at, int layer, Texel texel) { imageStore(out_poles_img, ivec3(at, layer), texel); }

// Mixes the solutions of a part and writes them, if the pixel is inside the picture.
void store(ivec2 at, Link here, bool is_inside, inout Output o, int part) {
#if POLES_PER_TEXEL == 2
    for (int k = 0; k + 1 < POLES; k += 2) {
        uvec4 texel = uvec4(mix_poles(o, k), mix_poles(o, k + 1));
        if (is_inside) write_texel(at, layer_of(part, k), texel);
    }
#if HAS_SINGLE_POLE
    Packed single = mix_poles(o, POLES - 1);
    if (part == 1 && is_inside) write_texel(at, POLES - 1, uvec4(o.single, single));
    o.single = single;
#endif
#else
    if (!is_inside) return;
    for (int k = 0; k < POLES; ++k) {
#if defined HALF_POLES && COMPLEX
        write_texel(at, k, mix_poles(o, k));
#elif defined HALF_POLES
        write_texel(at, k, uvec4(mix_poles(o, k), 0u, 0u));
#elif COMPLEX && PARTS == 1
        Value z = mix_poles(o, k);
        write_texel(at, 2 * k, z[0]);
        write_texel(at, 2 * k + 1, z[1]);
#elif COMPLEX
        write_texel(at, layer_of(part, k), vec4(mix_poles(o, k)));
#else
        write_texel(at, k, mix_poles(o, k));
#endif
    }
#endif
}

#else
struct Input {
    Value z;
};

struct Source {
    Value z;
};

// The rows' output at a pixel, in one layer of the texture.
Texel texel_at(ivec2 at, int layer) { return texelFetch(poles_tx, ivec3(at, layer), 0); }

Input input_at(ivec2 at, int part, int pole) {
#if POLES_PER_TEXEL == 2
    uvec4 texel = texel_at(at, layer_of(part, pole - pole % 2));
    bool is_first = pole % 2 == 0 && !(pole == POLES - 1 && part == 1);
    return Input(unpack(is_first ? texel.xy : texel.zw));
#elif defined HALF_POLES && COMPLEX
    return Input(unpack(texel_at(at, pole)));
#elif defined HALF_POLES
    return Input(unpack(texel_at(at, pole).xy));
#elif COMPLEX && PARTS == 1
    return Input(Value(texel_at(at, 2 * pole), texel_at(at, 2 * pole + 1)));
#else
    return Input(Value(texel_at(at, layer_of(part, pole))));
#endif
}

Source source_of(Input before, Input here, Input after, float b_in, float b_out) {
    float c_in = compact_at(b_in), c_out = compact_at(b_out);
    return Source(here.z + c_in * (before.z - here.z) + c_out * (after.z - here.z));
}

Value source(Source s, int part, int pole) { return s.z; }

struct Output {
    vec4 y;
};

void clear_output(out Output o) { o.y = vec4(0.0); }

void add_pole(inout Output o, int part, int pole, Value y) {
    Channels real = real_of_product(sum_weights[pole], y);
#if PARTS == 2
    if (part == 0) o.y.xy += real;
    else o.y.zw += real;
#else
    o.y += real;
#endif
}

void store(ivec2 at, Link here, bool is_inside, inout Output o, int part) {
    if (part == PARTS - 1 && is_inside) store_color(at, o.y, here == 0.0);
}
#endif

// Enlarges a picture a whole number of times by cubic interpolation, with the same result as rescale.comp.glsl. Each
// invocation writes all the pixels that one pixel of the source becomes: it reads 25 pixels for all of them, instead of
// 16 for each.
//
// Inputs
//   FACTOR    how many times: 2 or 3
//   from_tx   rgba
// Output
//   out_img   rgba, FACTOR times as large; what lies beyond the border of the source is read from the border

layout(local_size_x = PIXEL_GROUP, local_size_y = PIXEL_GROUP) in;

uniform sampler2D from_tx;
writeonly uniform image2D out_img;

// The least and the greatest of some pixels.
struct Range { vec4 low, high; };

vec4 value_at(ivec2 at) { return texelFetch(from_tx, clamp(at, ivec2(0), textureSize(from_tx, 0) - 1), 0); }

// Where part `k` of a pixel lies, in pixels from its center.
float shift_of(int k) { return (float(k) + 0.5) / float(FACTOR) - 0.5; }

// The weight of a pixel in a part of another one: the cubic of Keys 1981 with a = -1/2, by their distance in pixels.
float weight_of(int pixel, int k) {
    float d = abs(float(pixel) - shift_of(k));
    if (d >= 2.0) return 0.0;
    return d < 1.0 ? (1.5 * d - 2.5) * d * d + 1.0 : ((-0.5 * d + 2.5) * d - 4.0) * d + 2.0;
}

// The sum of five pixels beside each other, in part `k` of the middle one.
vec4 blend(vec4 v[5], int k) {
    return weight_of(-2, k) * v[0] + weight_of(-1, k) * v[1] + weight_of(0, k) * v[2] + weight_of(1, k) * v[3] +
           weight_of(2, k) * v[4];
}

// The row of the source `y` below `at`, in part `k` across.
void read_row(ivec2 at, out vec4 v[5]) {
    for (int x = 0; x < 5; ++x) v[x] = value_at(at + ivec2(x - 2, 0));
}

Range range_around(ivec2 first) {
    vec4 a = value_at(first), b = value_at(first + ivec2(1, 0)), c = value_at(first + ivec2(0, 1)), d = value_at(first + 1);
    return Range(min(min(a, b), min(c, d)), max(max(a, b), max(c, d)));
}

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(at, textureSize(from_tx, 0)))) return;
    vec4 across[FACTOR * 5];
    for (int y = 0; y < 5; ++y) {
        vec4 v[5];
        read_row(at + ivec2(0, y - 2), v);
        for (int k = 0; k < FACTOR; ++k) across[5 * k + y] = blend(v, k);
    }
    for (int k = 0; k < FACTOR; ++k)
        for (int j = 0; j < FACTOR; ++j) {
            vec4 v[5];
            for (int y = 0; y < 5; ++y) v[y] = across[5 * k + y];
            Range range = range_around(at - ivec2(shift_of(k) < 0.0 ? 1 : 0, shift_of(j) < 0.0 ? 1 : 0));
            imageStore(out_img, FACTOR * at + ivec2(k, j), clamp(blend(v, j), range.low, range.high));
        }
}

// Enlarges or reduces a picture about a point, by cubic interpolation.
//
// Inputs
//   from_tx   rgba, as large as the output unless `center` is the corner (0, 0)
//   center    the point that stays where it is, pixels
//   ratio     how far from `center` a pixel reads its source, relative to its own distance: above 1 reduces the picture
// Output
//   out_img   rgba; what lies beyond the border of the source is read from the border
//
// The cubic is Keys 1981 (a = -1/2). Its overshoot is clamped to the range of the four pixels around, so that
// highlights do not ring and colors do not become negative.

layout(local_size_x = PIXEL_GROUP, local_size_y = PIXEL_GROUP) in;

uniform sampler2D from_tx;
uniform vec2 center;
uniform float ratio;
writeonly uniform image2D out_img;

// The cubic's weights of four neighboring pixels, for a fraction `t` between the middle two.
vec4 weights(float t) {
    float t2 = t * t, t3 = t2 * t;
    return 0.5 * vec4(-t3 + 2.0 * t2 - t, 3.0 * t3 - 5.0 * t2 + 2.0, -3.0 * t3 + 4.0 * t2 + t, t3 - t2);
}

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy), last = textureSize(from_tx, 0) - 1;
    if (any(greaterThanEqual(at, imageSize(out_img)))) return;
    vec2 source_position = center + (vec2(at) + 0.5 - center) * ratio - 0.5;
    ivec2 first = ivec2(floor(source_position));
    vec4 across = weights(source_position.x - float(first.x)), down = weights(source_position.y - float(first.y));
    vec4 sum = vec4(0.0), low = vec4(0.0), high = vec4(0.0);
    for (int j = 0; j < 4; ++j)
        for (int i = 0; i < 4; ++i) {
            vec4 value = texelFetch(from_tx, clamp(first + ivec2(i, j) - 1, ivec2(0), last), 0);
            sum += across[i] * down[j] * value;
            // The middle four pixels give the range of the result.
            if (i == 1 && j == 1) low = high = value;
            if (i > 0 && i < 3 && j > 0 && j < 3) {
                low = min(low, value);
                high = max(high, value);
            }
        }
    imageStore(out_img, at, clamp(sum, low, high));
}

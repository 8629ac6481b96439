// The cheapest diffusion along lines: Thomas elimination with given conductances, one invocation a line.
// Two such sweeps, one along rows and one along columns, are the yardstick for the time of a frame.
//
// The diffused color y of a line solves one equation for each pixel i. r_i is the color before, and b_i is the
// conductance to the next pixel, which is 0 at the end of the line:
//   -b_(i-1) y_(i-1) + (1 + b_(i-1) + b_i) y_i - b_i y_(i+1) = r_i
//
// The elimination goes forward and expresses each y_i by the next one: y_i = constant_i + weight_i y_(i+1). The
// substitution then goes back from the last pixel.
//
// Inputs
//   conductance_img   r conductance b between a pixel and the next one along `axis`
//   color_img         rgba before the diffusion
// Scratch
//   weight_buf, constant_buf   weight and constant; the pixels of a line follow each other
// Output
//   out_color_img     rgba after the diffusion

layout(local_size_x = ROW_GROUP) in;

layout(r32f) uniform readonly image2D conductance_img;
layout(rgba32f) uniform readonly image2D color_img;
layout(rgba32f) uniform writeonly image2D out_color_img;
layout(std430) buffer bare_weight_block { float weight_buf[]; };
layout(std430) buffer bare_constant_block { vec4 constant_buf[]; };

uniform ivec2 axis;  // (1, 0) rows, (0, 1) columns
uniform int line_count;
uniform int line_length;

void main() {
    int line = int(gl_GlobalInvocationID.x);
    if (line >= line_count) return;
    int first = line * line_length;
    ivec2 start = line * axis.yx;
    float b_prev = 0.0, weight = 0.0;
    vec4 constant = vec4(0.0);
    for (int i = 0; i < line_length; ++i) {
        ivec2 at = start + i * axis;
        float b = imageLoad(conductance_img, at).r;
        float inverse = 1.0 / (1.0 + b + b_prev * (1.0 - weight));
        constant = (imageLoad(color_img, at) + b_prev * constant) * inverse;
        weight = b * inverse;
        weight_buf[first + i] = weight;
        constant_buf[first + i] = constant;
        b_prev = b;
    }
    vec4 y = vec4(0.0);
    for (int i = line_length - 1; i >= 0; --i) {
        y = constant_buf[first + i] + weight_buf[first + i] * y;
        imageStore(out_color_img, start + i * axis, y);
    }
}

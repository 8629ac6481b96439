// A line solved by one invocation: forward elimination, backward substitution, all poles at once.
// The least arithmetic of all strategies; right where a few wide cores run a line each.
//
// In network form (no diagonal is ever formed, so nothing cancels beside a wide blur):
//   u_i = g_i + b_(i-1) t_(i-1)      t_i = u_i / (u_i + b_i)
//   s_i = (r_i + b_(i-1) s_(i-1)) / (u_i + b_i)
//   y_i = s_i + b_i / (u_i + b_i) y_(i+1)
//
// SYSTEM names the network (a lib file); scratch holds s and the weight of y_(i+1) for the lines of
// one dispatch.

#include SYSTEM

layout(local_size_x = LINES_PER_GROUP) in;

layout(std430, binding = 0) buffer sweep_value_block { Value s_buf[]; };
layout(std430, binding = 1) buffer sweep_weight_block { Num w_buf[]; };

void eliminate_forward(int line, int slot) {
    Num t[POLES];
    Value s[POLES], r[POLES];
    for (int p = 0; p < POLES; ++p) { t[p] = ZERO_NUM; s[p] = ZERO_VALUE; }
    float b_prev = 0.0;
    Node node = node_at(pixel_at(line, 0));
    for (int i = 0; i < line_length; ++i) {
        ivec2 at = pixel_at(line, i);
        bool last = i + 1 == line_length;
        Node next = last ? node : node_at(at + axis);
        float b = last ? 0.0 : conductance(node, next);
        sources(at, r);
        for (int p = 0; p < POLES; ++p) {
            Num b_in = flow(p, b_prev), b_out = flow(p, b);
            Num u = num(specific_heat(node)) + mul(b_in, t[p]);
            Num inverse_sum = inverted(u + b_out);
            s[p] = mul(inverse_sum, r[p] + mul(b_in, s[p]));
            t[p] = mul(u, inverse_sum);
            int k = (slot * line_length + i) * POLES + p;
            s_buf[k] = s[p];
            w_buf[k] = mul(b_out, inverse_sum);
        }
        b_prev = b;
        node = next;
    }
}

void substitute_back(int line, int slot) {
    Value y[POLES];
    for (int p = 0; p < POLES; ++p) y[p] = ZERO_VALUE;
    for (int i = line_length - 1; i >= 0; --i) {
        ivec2 at = pixel_at(line, i);
        vec4 sum = vec4(0.0);
        for (int p = 0; p < POLES; ++p) {
            int k = (slot * line_length + i) * POLES + p;
            y[p] = s_buf[k] + mul(w_buf[k], y[p]);
#ifdef ROWS
            store_pole(at, p, y[p]);
#else
            sum += real_part(y[p]);
#endif
        }
#ifndef ROWS
        store_sum(at, sum);
#endif
    }
}

void main() {
    int slot = int(gl_GlobalInvocationID.x);
    if (slot >= line_count) return;
    eliminate_forward(first_line + slot, slot);
    substitute_back(first_line + slot, slot);
}

// A line solved by many invocations: each eliminates the inside of a run of RUN pixels, the run ends
// are solved together in shared memory by cyclic reduction, and each run is substituted back.
// Zhang, Cohen, Owens 2010; Laszlo, Giles, Appleyard 2016. Made for GPUs: pixels are read from
// memory once a pole and everything between stays in registers and shared memory.
//
// Elimination is star-mesh: taking away a pixel with ground g, source r and conductances b to the
// left, c to the right joins its neighbours by bc/D, D = g + b + c, and hands them gb/D, rb/D and
// gc/D, rc/D. Nothing is ever subtracted.
//
//      separator k-1      run k: RUN - 1 inner pixels      separator k
//   ------[ S ]--------[ i ]--[ i ]--[ i ]--[ i ]------------[ S ]------
//            `----------- c: what joins it to the pixel at hand
//
// Several lines share a workgroup (LINES_PER_GROUP, fastest index), so columns load coalesced.
// Every invocation reaches every barrier: beyond the line's end pixels are joined to nothing.

#include SYSTEM

layout(local_size_x = LINES_PER_GROUP, local_size_y = RUNS) in;

#define SLOTS (LINES_PER_GROUP * RUNS)  // 56 bytes each must fit 32 KiB, the least GL 4.3 allows

shared Value r_sh[SLOTS];
shared Num g_sh[SLOTS];
shared Num left_sh[SLOTS];
shared Num right_sh[SLOTS];

#define NO_LINE (-1)

int line_of_invocation() {
    int slot = int(gl_GlobalInvocationID.x);
    return slot < line_count ? first_line + slot : NO_LINE;
}

int slot_of(int run) { return run * LINES_PER_GROUP + int(gl_LocalInvocationID.x); }

// Solve the chain of separators; the answer replaces r_sh. RUNS is a power of two.
void solve_separators(int run) {
    int me = slot_of(run);
    for (int reach = 1; reach < RUNS; reach *= 2) {
        if ((run + 1) % (2 * reach) == 0) {
            int i = slot_of(run - reach);
            Num inverse_sum = inverted(g_sh[i] + left_sh[i] + right_sh[i]);
            Num share = mul(right_sh[i], inverse_sum);
            g_sh[me] += mul(g_sh[i], share);
            r_sh[me] += mul(share, r_sh[i]);
            left_sh[me] = mul(left_sh[i], share);
            if (run + reach < RUNS) {
                int k = slot_of(run + reach);
                share = mul(left_sh[k], inverted(g_sh[k] + left_sh[k] + right_sh[k]));
                g_sh[me] += mul(g_sh[k], share);
                r_sh[me] += mul(share, r_sh[k]);
                right_sh[me] = mul(right_sh[k], share);
            }
        }
        barrier();
    }
    if (run == RUNS - 1) r_sh[me] = mul(inverted(g_sh[me]), r_sh[me]);
    barrier();
    for (int reach = RUNS / 2; reach > 0; reach /= 2) {
        if ((run + 1) % (2 * reach) == reach) {
            Value sum = r_sh[me] + mul(right_sh[me], r_sh[slot_of(run + reach)]);
            if (run >= reach) sum += mul(left_sh[me], r_sh[slot_of(run - reach)]);
            r_sh[me] = mul(inverted(g_sh[me] + left_sh[me] + right_sh[me]), sum);
        }
        barrier();
    }
}

// Solve pole p; y receives the run's pixels, the separator last.
void solve_pole(int p, int line, int run, out Value y[RUN]) {
    Num to_left[RUN], to_next[RUN];
    int first = run * RUN, me = slot_of(run);
    bool inside = line != NO_LINE && first < line_length;
    Node node = inside ? node_at(pixel_at(line, first)) : NODE_OUTSIDE;
    Num c = ZERO_NUM, g = num(1.0), g_left = ZERO_NUM;
    Value r = ZERO_VALUE, r_left = ZERO_VALUE;
    if (inside) {
        g = num(specific_heat(node));
        r = source(pixel_at(line, first), p);
        if (run > 0) c = flow(p, conductance(node_at(pixel_at(line, first - 1)), node));
    }
    for (int j = 0; j < RUN - 1; ++j) {
        bool goes_on = line != NO_LINE && first + j + 1 < line_length;
        ivec2 next_at = pixel_at(line, first + j + 1);
        Node next = goes_on ? node_at(next_at) : NODE_OUTSIDE;
        Num b = goes_on ? flow(p, conductance(node, next)) : ZERO_NUM;
        Num inverse_sum = inverted(g + c + b);
        to_left[j] = mul(c, inverse_sum);
        to_next[j] = mul(b, inverse_sum);
        y[j] = mul(inverse_sum, r);
        g_left += mul(g, to_left[j]);
        r_left += mul(to_left[j], r);
        c = mul(c, to_next[j]);
        g = num(goes_on ? specific_heat(next) : 1.0) + mul(g, to_next[j]);
        r = mul(to_next[j], r);
        if (goes_on) r += source(next_at, p);
        node = next;
    }
    g_sh[me] = g_left;
    r_sh[me] = r_left;
    left_sh[me] = c;
    barrier();
    Num right = ZERO_NUM;
    if (run + 1 < RUNS) {
        int after = slot_of(run + 1);
        g += g_sh[after];
        r += r_sh[after];
        right = left_sh[after];
    }
    barrier();
    g_sh[me] = g;
    r_sh[me] = r;
    right_sh[me] = right;
    barrier();
    solve_separators(run);
    Value before = run > 0 ? r_sh[slot_of(run - 1)] : ZERO_VALUE;
    y[RUN - 1] = r_sh[me];
    for (int j = RUN - 2; j >= 0; --j) y[j] += mul(to_left[j], before) + mul(to_next[j], y[j + 1]);
    barrier();  // the next pole reuses shared memory
}

void main() {
    int line = line_of_invocation();
    int run = int(gl_LocalInvocationID.y);
    Value y[RUN];
    vec4 sum[RUN];
    for (int j = 0; j < RUN; ++j) sum[j] = vec4(0.0);
    for (int p = 0; p < POLES; ++p) {
        solve_pole(p, line, run, y);
        for (int j = 0; j < RUN; ++j) {
            int i = run * RUN + j;
            sum[j] += real_part(y[j]);
#ifdef ROWS
            if (line != NO_LINE && i < line_length) store_pole(pixel_at(line, i), p, y[j]);
#endif
        }
    }
#ifndef ROWS
    for (int j = 0; j < RUN; ++j) {
        int i = run * RUN + j;
        if (line != NO_LINE && i < line_length) store_sum(pixel_at(line, i), sum[j]);
    }
#endif
}

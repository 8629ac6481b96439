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

// What the line holds at a place of this run; beyond its end the last pixel again, joined to nothing.
Input input_in(int line, int i) { return input_at(pixel_at(line, clamp(i, 0, line_length - 1))); }

// Solve pole p; y receives the run's pixels, the separator last.
void solve_pole(int p, int line, int run, out Value y[RUN]) {
    Num to_left[RUN], to_next[RUN];
    int first = run * RUN, me = slot_of(run);
    bool inside = first < line_length;
    Input before = input_in(line, first - 1), here = input_in(line, first), after;
    float b_in = run > 0 && inside ? conductance(before, here) : 0.0, b_out;
    Num c = flow(p, b_in), g = ZERO_NUM, g_left = ZERO_NUM;
    Value r = ZERO_VALUE, r_left = ZERO_VALUE;
    for (int j = 0; j < RUN; ++j) {
        int i = first + j;
        after = input_in(line, i + 1);
        b_out = i + 1 < line_length ? conductance(here, after) : 0.0;
        Value own = source(source_of(before, here, after, b_in, b_out), p);
        r = j == 0 ? own : r + own;
        g += num(specific_heat(here));
        before = here;
        here = after;
        b_in = b_out;
        if (j == RUN - 1) break;
        Num b = flow(p, b_out);
        Num inverse_sum = inverted(g + c + b);
        to_left[j] = mul(c, inverse_sum);
        to_next[j] = mul(b, inverse_sum);
        y[j] = mul(inverse_sum, r);
        g_left += mul(g, to_left[j]);
        r_left += mul(to_left[j], r);
        c = mul(c, to_next[j]);
        g = mul(g, to_next[j]);
        r = mul(to_next[j], r);
    }
    g_sh[me] = g_left;
    r_sh[me] = r_left;
    left_sh[me] = c;
    barrier();
    Num right = ZERO_NUM;
    if (run + 1 < RUNS) {
        int after_me = slot_of(run + 1);
        g += g_sh[after_me];
        r += r_sh[after_me];
        right = left_sh[after_me];
    }
    barrier();
    g_sh[me] = g;
    r_sh[me] = r;
    right_sh[me] = right;
    barrier();
    solve_separators(run);
    Value left_end = run > 0 ? r_sh[slot_of(run - 1)] : ZERO_VALUE;
    y[RUN - 1] = r_sh[me];
    for (int j = RUN - 2; j >= 0; --j) y[j] += mul(to_left[j], left_end) + mul(to_next[j], y[j + 1]);
    barrier();  // the next pole reuses shared memory
}

void main() {
    int line = line_of_invocation();
    int run = int(gl_LocalInvocationID.y);
    Value y[RUN];
    Output o[RUN];
    for (int j = 0; j < RUN; ++j) clear_output(o[j]);
    for (int p = 0; p < POLES; ++p) {
        solve_pole(p, max(line, 0), run, y);
        for (int j = 0; j < RUN; ++j) add_pole(o[j], p, y[j]);
    }
    for (int j = 0; j < RUN; ++j) {
        int i = run * RUN + j;
        if (line != NO_LINE && i < line_length) store(pixel_at(line, i), o[j]);
    }
}

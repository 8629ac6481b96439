// Solves a line with many invocations: each eliminates the inside of a run of RUN pixels, the run ends
// are solved together in shared memory by cyclic reduction, and each run is substituted back.
// Zhang, Cohen, Owens 2010; Laszlo, Giles, Appleyard 2016. Made for GPUs: every pixel is read from
// memory once, and intermediate results stay in registers and shared memory.
//
// Elimination is star-mesh: taking away a pixel with ground g, source r and conductances b to the
// left, c to the right joins its neighbours by bc/D, D = g + b + c, and hands them gb/D, rb/D and
// gc/D, rc/D. Nothing is ever subtracted.
//
//      separator k-1      run k: RUN - 1 inner pixels      separator k
//   ------[ S ]--------[ i ]--[ i ]--[ i ]--[ i ]------------[ S ]------
//            `----------- c: conductance to the current pixel
//
// Several lines share a workgroup (LINES_PER_GROUP, fastest index), so columns load coalesced.
// Pixels beyond the line's end, and those in inactive tiles, are connected to nothing, and are neither
// read nor written. A workgroup with no other pixels ends at once; in all others every invocation
// reaches every barrier.
//
// SYSTEM names the network, a lib file that follows the contract in shaders/README.md. To save registers
// its channels are solved in PARTS, and each pixel is requested in two steps, as the contract says.

#include SYSTEM
#ifndef Link
#include "lib/one_part.lib.glsl"
#endif
#include "lib/tile_mask.lib.glsl"

layout(local_size_x = LINES_PER_GROUP, local_size_y = RUNS) in;

#define SLOTS (LINES_PER_GROUP * RUNS)  // 56 bytes each must fit 32 KiB, the least GL 4.3 allows

shared Value r_sh[SLOTS];
shared Num g_sh[SLOTS];
shared Num left_sh[SLOTS];
shared Num right_sh[SLOTS];
shared int has_work_sh;  // 0 or 1

int slot_of(int run) { return run * LINES_PER_GROUP + int(gl_LocalInvocationID.x); }

Num inverse_sum_of(int slot) { return inverted(g_sh[slot] + left_sh[slot] + right_sh[slot]); }

// Eliminates the separators `reach` before and after the one that stays.
void reduce_onto(int run, int reach) {
    int me = slot_of(run), i = slot_of(run - reach);
    Num share = mul(right_sh[i], inverse_sum_of(i));
    g_sh[me] += mul(g_sh[i], share);
    r_sh[me] += mul(share, r_sh[i]);
    left_sh[me] = mul(left_sh[i], share);
    if (run + reach >= RUNS) return;
    int k = slot_of(run + reach);
    share = mul(left_sh[k], inverse_sum_of(k));
    g_sh[me] += mul(g_sh[k], share);
    r_sh[me] += mul(share, r_sh[k]);
    right_sh[me] = mul(right_sh[k], share);
}

void substitute_between(int run, int reach) {
    int me = slot_of(run);
    Value sum = r_sh[me];
    if (run >= reach) sum += mul(left_sh[me], r_sh[slot_of(run - reach)]);
    if (run + reach < RUNS) sum += mul(right_sh[me], r_sh[slot_of(run + reach)]);
    r_sh[me] = mul(inverse_sum_of(me), sum);
}

// Solves the chain of separators; the solution replaces r_sh. The first invocations do the work, so that
// whole waves are idle when few separators are left.
void solve_separators(int worker) {
    int reach = 1;
    for (; 2 * reach <= RUNS; reach *= 2) {
        int run = (worker + 1) * 2 * reach - 1;
        if (run < RUNS) reduce_onto(run, reach);
        barrier();
    }
    int last = slot_of(reach - 1);
    if (worker == 0) r_sh[last] = mul(inverted(g_sh[last]), r_sh[last]);
    barrier();
    for (reach /= 2; reach > 0; reach /= 2) {
        int run = (2 * worker + 1) * reach - 1;
        if (run < RUNS) substitute_between(run, reach);
        barrier();
    }
}

// The run of consecutive pixels that one invocation solves.
struct Run {
    int line, first, last;  // its first and last readable pixel, including connected neighbours
    int in_work[RUN];       // 0 or 1: some drivers take no bools in an array
    Link link[RUN];
    float b[RUN + 1];       // conductances: to the pixel before, between the pixels, to the pixel after
};

bool is_in_work(int line, int i) {
    if (line >= first_line + line_count || i < 0 || i >= line_length) return false;
    return is_tile_active(i / TILE * axis + line / TILE * axis.yx);
}

ivec2 place_in(Run r, int i) { return pixel_at(r.line, clamp(i, r.first, r.last)); }

bool is_empty(Run r) {
    bool any_in_work = false;
    for (int j = 0; j < RUN; j += TILE) any_in_work = any_in_work || r.in_work[j] != 0;
    return !any_in_work;
}

// The pixels of a tile are active or inactive together, up to the end of the line.
void find_work(inout Run r, int start) {
    for (int j = 0; j < RUN; ++j)
        r.in_work[j] = is_in_work(r.line, start + j / TILE * TILE) && start + j < line_length ? 1 : 0;
    bool has_before = r.in_work[0] != 0 && is_in_work(r.line, start - 1);
    bool has_after = r.in_work[RUN - 1] != 0 && is_in_work(r.line, start + RUN);
    r.first = has_before ? start - 1 : start;
    r.last = has_after ? start + RUN : min(start + RUN, line_length) - 1;
}

void read_links(inout Run r, int start) {
    Link before = link_at(place_in(r, start - 1));
    for (int j = 0; j < RUN; ++j) {
        r.link[j] = link_at(place_in(r, start + j));
        bool is_joined = j == 0 ? r.first < start : (r.in_work[j - 1] & r.in_work[j]) != 0;
        if (is_joined) r.b[j] = conductance(before, r.link[j]);
        before = r.link[j];
    }
    if (r.last == start + RUN) r.b[RUN] = conductance(before, link_at(place_in(r, start + RUN)));
}

Run run_from(int line, int start) {
    Run r;
    r.line = line;
    find_work(r, start);
    for (int j = 0; j <= RUN; ++j) r.b[j] = 0.0;
    if (!is_empty(r)) read_links(r, start);
    return r;
}

void read_sources(Run r, int start, int part, int pole, inout Source s[RUN]) {
    if (is_empty(r)) return;
    Input before = input_at(place_in(r, start - 1), part, pole);
    Input here = input_at(place_in(r, start), part, pole);
    for (int j = 0; j < RUN; ++j) {
        Input after = input_at(place_in(r, start + j + 1), part, pole), next = after;
        if (r.b[j] == 0.0) before = here;
        if (r.b[j + 1] == 0.0) next = here;
        s[j] = source_of(before, here, next, r.b[j], r.b[j + 1]);
        before = here;
        here = after;
    }
}

// The heat capacity beyond the line's ends, if pixel `i` is one of them.
Num beyond(Run r, int j, int i, int pole) {
    int ends = r.in_work[j] == 0 ? 0 : int(i == 0) + int(i == line_length - 1);
    return ends == 0 ? ZERO_NUM : float(ends) * repeated_heat(pole, r.link[j]);
}

Num heat_of(Run r, int start, int j, int pole) {
    return num(r.in_work[j] != 0 ? specific_heat(r.link[j]) : 1.0) + beyond(r, j, start + j, pole);
}

// The shares of its neighbours in the solution of an eliminated pixel.
struct Shares {
    Num left[RUN], next[RUN];
};

// Eliminates all but the last pixel of a run, whose right-hand sides are in y, onto its two ends.
void eliminate_run(Run r, int pole, int run, inout Value y[RUN], out Shares shares) {
    int me = slot_of(run), start = run * RUN;
    Num c = flow(pole, r.b[0]), g = heat_of(r, start, 0, pole), g_left = ZERO_NUM;
    Value r_left = ZERO_VALUE;
    for (int j = 0; j < RUN - 1; ++j) {
        Num b = flow(pole, r.b[j + 1]);
        Num inverse_sum = inverted(g + c + b);
        shares.left[j] = mul(c, inverse_sum);
        shares.next[j] = mul(b, inverse_sum);
        g_left += mul(g, shares.left[j]);
        r_left += mul(shares.left[j], y[j]);
        c = mul(c, shares.next[j]);
        g = heat_of(r, start, j + 1, pole) + mul(g, shares.next[j]);
        y[j + 1] += mul(shares.next[j], y[j]);
        y[j] = mul(inverse_sum, y[j]);
    }
    g_sh[me] = g_left;
    r_sh[me] = r_left;
    left_sh[me] = c;
    barrier();
    Num right = ZERO_NUM;
    if (run + 1 < RUNS) {
        int after_me = slot_of(run + 1);
        g += g_sh[after_me];
        y[RUN - 1] += r_sh[after_me];
        right = left_sh[after_me];
    }
    barrier();
    g_sh[me] = g;
    r_sh[me] = y[RUN - 1];
    right_sh[me] = right;
    barrier();
}

void substitute_run(int run, Shares shares, inout Value y[RUN]) {
    Value left_end = run > 0 ? r_sh[slot_of(run - 1)] : ZERO_VALUE;
    y[RUN - 1] = r_sh[slot_of(run)];
    for (int j = RUN - 2; j >= 0; --j) y[j] += mul(shares.left[j], left_end) + mul(shares.next[j], y[j + 1]);
    barrier();  // the next pole reuses shared memory
}

// Adds the heat from beyond the line's ends, which has the colour of the end itself. `read` is
// the pole for which the sources were read last.
void repeat_ends(Run r, int start, int part, int pole, int read, inout Value y[RUN]) {
    for (int j = 0; j < RUN; ++j) {
        int i = start + j;
        if (!IS_REPEATED || r.in_work[j] == 0 || i > 0 && i < line_length - 1) continue;
        Input end = input_at(place_in(r, i), part, read);
        y[j] += mul(beyond(r, j, i, pole), source(source_of(end, end, end, 0.0, 0.0), part, pole));
    }
}

void solve_pole(Run r, Source s[RUN], int run, int part, int pole, int read, inout Output o[RUN]) {
    Value y[RUN];
    Shares shares;
    for (int j = 0; j < RUN; ++j) y[j] = r.in_work[j] != 0 ? source(s[j], part, pole) : ZERO_VALUE;
    repeat_ends(r, run * RUN, part, pole, read, y);
    eliminate_run(r, pole, run, y, shares);
    solve_separators(run);
    substitute_run(run, shares, y);
    for (int j = 0; j < RUN; ++j) add_pole(o[j], part, pole, y[j]);
}

// True if any invocation of the workgroup has something to solve.
bool has_group_work(Run r) {
    if (gl_LocalInvocationIndex == 0u) has_work_sh = 0;
    barrier();
    if (!is_empty(r)) has_work_sh = 1;
    barrier();
    return has_work_sh != 0;
}

void main() {
    int run = int(gl_LocalInvocationID.y), start = run * RUN;
    Run r = run_from(first_line + int(gl_GlobalInvocationID.x), start);
    if (!has_group_work(r)) return;
    Source s[RUN];
    Output o[RUN];
    for (int j = 0; j < RUN; ++j) clear_output(o[j]);
    for (int part = 0; part < PARTS; ++part) {
        int read = 0;
        for (int pole = 0; pole < POLES; ++pole) {
            if (is_source_read(part, pole)) {
                read = pole;
                read_sources(r, start, part, read, s);
            }
            solve_pole(r, s, run, part, pole, read, o);
        }
        for (int j = 0; j < RUN; ++j) store(pixel_at(r.line, start + j), r.link[j], r.in_work[j] != 0, o[j], part);
    }
}

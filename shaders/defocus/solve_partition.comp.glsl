// Solves a line with many invocations. Each eliminates the inside of a run of RUN pixels; the last pixels of the runs,
// the separators, are solved together in shared memory by cyclic reduction; then each run is substituted back. Zhang,
// Cohen, Owens 2010; Laszlo, Giles, Appleyard 2016. Made for GPUs: every pixel is read from memory once, and
// intermediate results stay in registers and shared memory.
//
// A line is a network: each pixel has a conductance (its heat capacity) to ground and one to each neighbor. Elimination
// is star-mesh: taking away a pixel with ground g, source r and conductances b to the left, c to the right joins its
// neighbors by bc/D, D = g + b + c, and hands them gb/D, rb/D and gc/D, rc/D. Nothing is ever subtracted.
//
//      separator k-1      run k: RUN - 1 inner pixels      separator k
//   ------[ S ]--------[ i ]--[ i ]--[ i ]--[ i ]------------[ S ]------
//            `----------- c: conductance to the current pixel
//
// A workgroup solves a segment, which is a run of active tiles of a line, in as many lines as it has invocations for
// (lib/line_segment.lib.glsl): short segments leave few invocations idle, and the loads of columns coalesce. Pixels
// around a segment and beyond the line's end are not connected, and are neither read nor written. Every invocation
// reaches every barrier.
//
// SYSTEM names the network, a lib file that follows the contract in shaders/README.md. It has POLES systems, which are
// solved one after the other; its add_pole combines their solutions. To save registers, channels are solved in PARTS,
// and each pixel is requested in two steps, as the contract says. Num is a coefficient, Value the channels of a part,
// both real or complex (lib/number.lib.glsl).

#include SYSTEM
#ifndef Link
#include "lib/one_part.lib.glsl"  // Link, link_at, input_at, source, add_pole, store
#endif
#include "lib/line_segment.lib.glsl"  // runs_in, lines_at_once

layout(local_size_x = SOLVER_SLOTS) in;

layout(std430) readonly buffer segment_block {
    uint segment_groups[3];  // workgroups of this pass
    uint segment_count;      // entries of the list
    uvec2 segment_buf[];     // x first line, y first tile << 16 | number of tiles
};

// Of each separator: source, ground, and conductances to the separators on both sides.
shared Value r_sh[SOLVER_SLOTS];
shared Num g_sh[SOLVER_SLOTS];
shared Num left_sh[SOLVER_SLOTS];
shared Num right_sh[SOLVER_SLOTS];

int lines, lane;  // lines that this workgroup solves at once, and the number of this one among them
int runs;         // number of runs of each line

// The index in shared memory of the separator at the end of a run; neighboring slots belong to neighboring lines.
int slot_of(int run) { return run * lines + lane; }

// 1 / (sum of a separator's conductances).
Num inverse_sum_of(int slot) { return inverted(g_sh[slot] + left_sh[slot] + right_sh[slot]); }

// Eliminates the separators `reach` runs before and after the one at the end of `run`, which stays.
void reduce_onto(int run, int reach) {
    int own = slot_of(run), i = slot_of(run - reach);
    Num share = mul(right_sh[i], inverse_sum_of(i));
    g_sh[own] += mul(g_sh[i], share);
    r_sh[own] += mul(share, r_sh[i]);
    left_sh[own] = mul(left_sh[i], share);
    if (run + reach >= runs) return;
    int k = slot_of(run + reach);
    share = mul(left_sh[k], inverse_sum_of(k));
    g_sh[own] += mul(g_sh[k], share);
    r_sh[own] += mul(share, r_sh[k]);
    right_sh[own] = mul(right_sh[k], share);
}

// Computes the solution of a separator from those `reach` runs before and after it.
void substitute_between(int run, int reach) {
    int own = slot_of(run);
    Value sum = r_sh[own];
    if (run >= reach) sum += mul(left_sh[own], r_sh[slot_of(run - reach)]);
    if (run + reach < runs) sum += mul(right_sh[own], r_sh[slot_of(run + reach)]);
    r_sh[own] = mul(inverse_sum_of(own), sum);
}

// Solves the chain of separators; the solution replaces r_sh. The first invocations do the work: when few
// separators are left, whole waves are idle.
void solve_separators(int worker) {
    int reach = 1;
    for (; 2 * reach <= runs; reach *= 2) {
        int run = (worker + 1) * 2 * reach - 1;
        if (run < runs) reduce_onto(run, reach);
        barrier();
    }
    int last = slot_of(reach - 1);
    if (worker == 0) r_sh[last] = mul(inverted(g_sh[last]), r_sh[last]);
    barrier();
    for (reach /= 2; reach > 0; reach /= 2) {
        int run = (2 * worker + 1) * reach - 1;
        if (run < runs) substitute_between(run, reach);
        barrier();
    }
}

// The run of consecutive pixels that one invocation solves.
struct Run {
    int line, start;        // its line, and its first pixel
    int first, last;        // its first and last readable pixel, including connected neighbors
    int count;              // pixels to solve, 0 to RUN
    Link link[RUN];
    float b[RUN + 1];       // conductances: to the pixel before, between the pixels, to the pixel after
};

// The pixel i of the run's line, or the nearest readable one.
ivec2 clamped_pixel(Run r, int i) { return pixel_at(r.line, clamp(i, r.first, r.last)); }

// Reads the pixels of a run and their conductances; those to pixels outside the segment stay 0.
void read_links(inout Run r) {
    Link before = link_at(clamped_pixel(r, r.start - 1));
    for (int j = 0; j < RUN; ++j) {
        r.link[j] = link_at(clamped_pixel(r, r.start + j));
        bool is_joined = j == 0 ? r.first < r.start : j < r.count;
        if (is_joined) r.b[j] = conductance(before, r.link[j]);
        before = r.link[j];
    }
    if (r.last == r.start + RUN) r.b[RUN] = conductance(before, link_at(clamped_pixel(r, r.start + RUN)));
}

// The run from `start` on in a segment from pixel `begin` to before `end`.
Run run_from(int line, int start, int begin, int end) {
    Run r;
    r.line = line;
    r.start = start;
    r.first = max(start - 1, begin);
    r.last = min(start + RUN, end - 1);
    r.count = line < line_count ? clamp(end - start, 0, RUN) : 0;
    for (int j = 0; j <= RUN; ++j) r.b[j] = 0.0;
    if (r.count > 0) read_links(r);
    return r;
}

// True if the run contains the first, or the last, pixel of a line with repeated pixels beyond its ends.
bool has_begin(Run r) { return IS_REPEATED && r.count > 0 && r.start == 0; }
bool has_end(Run r) { return IS_REPEATED && r.count > 0 && r.start + r.count == line_length; }

// Reads the right-hand sides of a run into y. In place of a neighbor that is not connected the pixel itself is given,
// as the contract asks.
void read_sources(Run r, int part, int pole, inout Value y[RUN]) {
    if (r.count == 0) return;
    Input before = input_at(clamped_pixel(r, r.start - 1), part, pole);
    Input here = input_at(clamped_pixel(r, r.start), part, pole);
    for (int j = 0; j < RUN; ++j) {
        Input after = input_at(clamped_pixel(r, r.start + j + 1), part, pole), next = after;
        if (r.b[j] == 0.0) before = here;
        if (r.b[j + 1] == 0.0) next = here;
        if (j < r.count) y[j] = source(source_of(before, here, next, r.b[j], r.b[j + 1]), part, pole);
        before = here;
        here = after;
    }
}

// The heat capacity beyond the line's begin and end, where they are in the run.
struct Ends {
    Num first, last;  // 0 where the run does not contain that end, or no pixels are repeated
};

// Finds the heat capacity beyond both ends, in one pole's network.
Ends ends_of(Run r, int pole) {
    Ends ends = Ends(ZERO_NUM, ZERO_NUM);
    if (has_begin(r)) ends.first = repeated_heat(pole, r.link[0]);
    if (has_end(r)) {
        // The link of the last pixel, by comparison: a varying index would move the array out of registers.
        Link link = r.link[0];
        for (int j = 1; j < RUN; ++j)
            if (j < r.count) link = r.link[j];
        ends.last = repeated_heat(pole, link);
    }
    return ends;
}

// The heat capacity of pixel j of a run, with what lies beyond the line's ends; 1 for pixels after the segment, which
// are connected to nothing.
Num heat_of(Run r, int j, Ends ends) {
    Num heat = num(j < r.count ? specific_heat(r.link[j]) : 1.0);
    if (j == 0) heat += ends.first;
    return j == r.count - 1 ? heat + ends.last : heat;
}

// The shares in the solution of each eliminated pixel: of the separator before the run, and of the next pixel.
struct Shares {
    Num left[RUN], next[RUN];
};

// Eliminates all but the last pixel of a run, whose right-hand sides are in y, onto its two ends.
void eliminate_run(Run r, int pole, int run, Ends ends, inout Value y[RUN], out Shares shares) {
    int own = slot_of(run);
    // c: conductance from the separator before the run to the current pixel; g: ground of the current pixel; g_left,
    // r_left: ground and source handed to the separator before the run so far.
    Num c = flow(pole, r.b[0]), g = heat_of(r, 0, ends), g_left = ZERO_NUM;
    Value r_left = ZERO_VALUE;
    for (int j = 0; j < RUN - 1; ++j) {
        Num b = flow(pole, r.b[j + 1]);
        Num inverse_sum = inverted(g + c + b);
        shares.left[j] = mul(c, inverse_sum);
        shares.next[j] = mul(b, inverse_sum);
        g_left += mul(g, shares.left[j]);
        r_left += mul(shares.left[j], y[j]);
        c = mul(c, shares.next[j]);
        g = heat_of(r, j + 1, ends) + mul(g, shares.next[j]);
        y[j + 1] += mul(shares.next[j], y[j]);
        y[j] = mul(inverse_sum, y[j]);
    }
    g_sh[own] = g_left;
    r_sh[own] = r_left;
    left_sh[own] = c;
    barrier();
    Num right = ZERO_NUM;
    if (run + 1 < runs) {
        int next_slot = slot_of(run + 1);
        g += g_sh[next_slot];
        y[RUN - 1] += r_sh[next_slot];
        right = left_sh[next_slot];
    }
    barrier();
    g_sh[own] = g;
    r_sh[own] = y[RUN - 1];
    right_sh[own] = right;
    barrier();
}

// Computes the solution of all pixels of a run from those of its two ends.
void substitute_run(int run, Shares shares, inout Value y[RUN]) {
    Value left_end = run > 0 ? r_sh[slot_of(run - 1)] : ZERO_VALUE;
    y[RUN - 1] = r_sh[slot_of(run)];
    for (int j = RUN - 2; j >= 0; --j) y[j] += mul(shares.left[j], left_end) + mul(shares.next[j], y[j + 1]);
    barrier();  // the next pole reuses shared memory
}

// The right-hand side of a pixel by itself, as if it had no neighbors.
Value value_at(Run r, int i, int part, int pole) {
    Input here = input_at(pixel_at(r.line, i), part, pole);
    return source(source_of(here, here, here, 0.0, 0.0), part, pole);
}

// Adds the heat from beyond the line's ends, which has the color of the end itself.
void add_ends(Run r, Ends ends, int part, int pole, inout Value y[RUN]) {
    if (has_begin(r)) y[0] += mul(ends.first, value_at(r, 0, part, pole));
    if (!has_end(r)) return;
    Value last = mul(ends.last, value_at(r, line_length - 1, part, pole));
    for (int j = 0; j < RUN; ++j)
        if (j == r.count - 1) y[j] += last;
}

// Solves one part of one pole, and adds it to the output.
void solve_pole(Run r, int run, int part, int pole, inout Output o[RUN]) {
    Value y[RUN];
    Shares shares;
    Ends ends = ends_of(r, pole);
    for (int j = 0; j < RUN; ++j) y[j] = ZERO_VALUE;
    read_sources(r, part, pole, y);
    add_ends(r, ends, part, pole, y);
    eliminate_run(r, pole, run, ends, y, shares);
    solve_separators(run);
    substitute_run(run, shares, y);
    for (int j = 0; j < RUN; ++j) add_pole(o[j], part, pole, y[j]);
}

void main() {
    uint number = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x;
    if (number >= segment_count) return;
    uvec2 segment = segment_buf[number];
    int begin = int(segment.y >> 16) * TILE, tiles = int(segment.y & 0xffffu);
    runs = runs_in(tiles, RUN);
    lines = lines_at_once(runs);
    int run = int(gl_LocalInvocationIndex) / lines, start = begin + run * RUN;
    lane = int(gl_LocalInvocationIndex) - run * lines;
    int line = int(segment.x) + lane;
    bool is_used = run < runs && line / TILE == int(segment.x) / TILE;  // the last lines of a tile may be fewer
    Run r = run_from(is_used ? line : line_count, start, begin, min(begin + tiles * TILE, line_length));
    Output o[RUN];
    for (int j = 0; j < RUN; ++j) clear_output(o[j]);
    for (int part = 0; part < PARTS; ++part) {
        for (int pole = 0; pole < POLES; ++pole) solve_pole(r, run, part, pole, o);
        for (int j = 0; j < RUN; ++j) store(pixel_at(r.line, start + j), r.link[j], j < r.count, o[j], part);
    }
}

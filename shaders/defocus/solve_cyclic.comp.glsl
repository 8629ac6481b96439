// Solves lines by plain cyclic reduction, as in the memo by Kass, Lefohn and Owens 2006: each stage is a pass over
// memory, log2(n) of them down and up for n pixels. Kept as a simple reference for the other two strategies.
//
// A stage is one dispatch over (pixels, lines). In stage `reach`, pixels at multiples of 2 `reach` survive; the others
// that are left, at odd multiples of `reach`, are eliminated into them (by star-mesh, see solve_partition.comp.glsl),
// and keep their data for the substitution on the way up. The whole picture is solved; the tile mask is ignored.
//
// SYSTEM names the network, a lib file that follows the contract in shaders/README.md. It has POLES systems, which are
// solved independently of each other; its add_pole combines their solutions. Num is a coefficient, Value four
// channels, both real or complex (lib/number.lib.glsl).
//
// STAGE chooses what the build does: LOAD fills the network from the picture, REDUCE eliminates, SUBSTITUTE solves, and
// STORE writes the solution.

#include SYSTEM

#define LOAD 0
#define REDUCE 1
#define SUBSTITUTE 2
#define STORE 3

layout(local_size_x = CYCLIC_GROUP) in;

struct Link {
    Num ground, left, right;  // conductances: to ground, to the neighbors that are left
};
layout(std430) buffer cyclic_value_block { Value r_buf[]; };  // right-hand sides, then solutions
layout(std430) buffer cyclic_link_block { Link link_buf[]; };

uniform int reach;  // distance in pixels of neighbors at this stage; 0 in the stage that solves the last survivor

// The index in both buffers of pixel i of line `slot` of the dispatch, for pole p.
int index_of(int slot, int i, int p) { return (slot * line_length + i) * POLES + p; }

// 1 / (sum of a pixel's conductances).
Num inverse_sum(Link l) { return inverted(l.ground + l.left + l.right); }

// Reads a pixel and its neighbors, and sets up its part of the network for all poles. Beyond the ends of the line the
// heat capacity of repeated pixels is added to the ground, with the color of the end itself.
void load(int slot, ivec2 at, int i) {
    bool has_left = i > 0, has_right = i + 1 < line_length;
    Input here = input_at(at), before = here, after = here;
    if (has_left) before = input_at(at - axis);
    if (has_right) after = input_at(at + axis);
    float left = has_left ? conductance(before, here) : 0.0;
    float right = has_right ? conductance(here, after) : 0.0;
    Source r = source_of(before, here, after, left, right), end = source_of(here, here, here, 0.0, 0.0);
    float ends = float(!has_left) + float(!has_right);
    for (int p = 0; p < POLES; ++p) {
        Num end_heat = ends * repeated_heat(p, here);
        link_buf[index_of(slot, i, p)] =
            Link(num(specific_heat(here)) + end_heat, flow(p, left), flow(p, right));
        r_buf[index_of(slot, i, p)] = source(r, p) + mul(end_heat, source(end, p));
    }
}

// Eliminates the neighbors of pixel i at a distance of `reach` into it.
void reduce(int slot, int i, int p) {
    int own = index_of(slot, i, p);
    Link mine = link_buf[own];
    Value r = r_buf[own];
    if (i >= reach) {
        int k = index_of(slot, i - reach, p);
        Link removed = link_buf[k];
        Num share = mul(removed.right, inverse_sum(removed));
        mine.ground += mul(removed.ground, share);
        mine.left = mul(removed.left, share);
        r += mul(share, r_buf[k]);
    }
    if (i + reach < line_length) {
        int k = index_of(slot, i + reach, p);
        Link removed = link_buf[k];
        Num share = mul(removed.left, inverse_sum(removed));
        mine.ground += mul(removed.ground, share);
        mine.right = mul(removed.right, share);
        r += mul(share, r_buf[k]);
    }
    link_buf[own] = mine;
    r_buf[own] = r;
}

// Computes the solution of pixel i from those of its neighbors at a distance of `reach`.
void substitute(int slot, int i, int p) {
    int own = index_of(slot, i, p);
    Link mine = link_buf[own];
    Value sum = r_buf[own];
    if (i >= reach) sum += mul(mine.left, r_buf[index_of(slot, i - reach, p)]);
    if (i + reach < line_length) sum += mul(mine.right, r_buf[index_of(slot, i + reach, p)]);
    r_buf[own] = mul(inverse_sum(mine), sum);
}

// Writes the solution of a pixel, from those of all poles.
void store_answers(int slot, ivec2 at, int i) {
    Output o;
    clear_output(o);
    for (int p = 0; p < POLES; ++p) add_pole(o, p, r_buf[index_of(slot, i, p)]);
    store(at, input_at(at), o);
}

void main() {
    int i = int(gl_GlobalInvocationID.x), slot = int(gl_GlobalInvocationID.y);
    if (i >= line_length || slot >= line_count) return;
    ivec2 at = pixel_at(first_line + slot, i);
#if STAGE == LOAD
    load(slot, at, i);
#elif STAGE == REDUCE
    if (i % (2 * reach) == 0)
        for (int p = 0; p < POLES; ++p) reduce(slot, i, p);
#elif STAGE == SUBSTITUTE
    // The first substitution has a reach of 0: it solves the last survivor, which has no neighbors left.
    if (reach > 0 ? i % (2 * reach) == reach : i == 0)
        for (int p = 0; p < POLES; ++p) substitute(slot, i, p);
#else
    store_answers(slot, at, i);
#endif
}

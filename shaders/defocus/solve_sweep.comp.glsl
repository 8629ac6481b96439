// Solves a line with one invocation: forward elimination and backward substitution, for all poles at once. It needs the
// least arithmetic of all strategies, and suits CPUs, where a few wide cores run a line each.
//
// A line is a network: pixel i has the heat capacity g_i to ground, the source r_i and the conductance b_i to the next
// pixel. An eliminated pixel passes the share w_i of its heat capacity and of its source to the next one, which then
// has u_i and s_i in all; y_i is the solution. No diagonal is ever formed, and so nothing cancels next to a wide blur:
//   u_i = g_i + w_(i-1) u_(i-1)      s_i = r_i + w_(i-1) s_(i-1)      w_i = b_i / (u_i + b_i)
//   y_i = s_i / (u_i + b_i) + w_i y_(i+1)
//
// Memory costs a CPU more than arithmetic: the forward pass stores its state only once for each BLOCK of pixels, and
// the backward pass eliminates each block again, in registers. Inactive tiles are neither read nor written; nothing
// flows into them.
//
// With IS_REPEATED, a line continues beyond both ends of the picture with copies of its end pixel; `repeated_heat` is
// the heat capacity of all copies together. `slot` is the number of the line among those that are solved at once.
//
// SYSTEM names the network, a lib file that follows the contract in shaders/README.md. It has POLES systems, which are
// solved independently of each other; its add_pole combines their solutions. Num is a coefficient, Value four
// channels, both real or complex (lib/number.lib.glsl).

#include SYSTEM
#include "lib/each.lib.glsl"  // EACH_POLE, EACH_PIXEL, EACH_PIXEL_BACK
#include "lib/tile_mask.lib.glsl"  // is_tile_active

layout(local_size_x = LINES_PER_GROUP) in;

// The state before each block, for each pole: what the previous pixel passes on of its source and heat capacity.
layout(std430) buffer sweep_value_block { Value s_buf[]; };
layout(std430) buffer sweep_heat_block { Num u_buf[]; };

#define BLOCKS_PER_LINE ((line_length + BLOCK - 1) / BLOCK)

// Loop bodies of the functions below, for each pole or for each pixel of a block.
#define ELIMINATE_POLE(p) eliminate_pole(carry, at.here, source(r, p), b_out, p, removed);
#define CLEAR_CARRY_POLE(p) carry.source[p] = ZERO_VALUE; carry.heat[p] = ZERO_NUM;
#define SAVE_POLE(p) s_buf[state_index(slot, i, p)] = carry.source[p]; u_buf[state_index(slot, i, p)] = carry.heat[p];
#define LOAD_POLE(p) carry.source[p] = s_buf[state_index(slot, i, p)]; carry.heat[p] = u_buf[state_index(slot, i, p)];
#define SUBSTITUTE_POLE(p) y[p] = mul(removed.inverse[p], removed.s[p]) + mul(removed.w[p], y[p]); add_pole(o, p, y[p]);
#define ELIMINATE_AGAIN(j) eliminate(carry, at, line, run, first + j, removed[j]);
#define SUBSTITUTE(j) substitute(removed[j], y, pixel_at(line, first + j), first + j < run.end);
#define CLEAR_POLE(p) y[p] = ZERO_VALUE;
#define REPEAT_FIRST_POLE(p) carry.heat[p] = repeated_heat(p, here); carry.source[p] = mul(carry.heat[p], source(r, p));
#define REPEAT_LAST_POLE(p) y[p] = repeat_end(carry.heat[p], carry.source[p], repeated_heat(p, here), source(r, p));

// The state carried over from the previous pixels: w_(i-1) s_(i-1) and w_(i-1) u_(i-1) of each pole.
struct Carry {
    Value source[POLES];
    Num heat[POLES];
};

// An eliminated pixel and its state.
struct Eliminated {
    Input here;
    Value s[POLES];
    Num inverse[POLES], w[POLES];  // 1 / (u_i + b_i), and w_i
};

// The range of pixels of a line that count as connected around a tile.
struct Run {
    int start, end;
    int joined_end;  // pixels before it have a neighbor after them
};

// True if a tile of a line is active.
bool is_active_tile(int line, int tile) {
    if (tile < 0 || tile * TILE >= line_length) return false;
    return is_tile_active(tile * axis + line / TILE * axis.yx);
}

// The range around an active tile: on a side with another active tile it goes on to the line's end, which is farther
// than any use of it.
Run run_of(int line, int tile) {
    int start = is_active_tile(line, tile - 1) ? 0 : tile * TILE;
    int end = is_active_tile(line, tile + 1) ? line_length : min((tile + 1) * TILE, line_length);
    return Run(start, end, IS_REPEATED && end == line_length ? end + TILE : end);
}

// The first active tile from this one on (or the number of tiles), and the last one up to it (or -1). Each line skips
// its inactive tiles in this cheap loop, because a CPU that solves lines side by side runs a loop body for all of
// them, also for those with nothing to do.
int next_active(int line, int tile, int tiles) {
    while (tile < tiles && !is_active_tile(line, tile)) ++tile;
    return tile;
}
int last_active(int line, int tile) {
    while (tile >= 0 && !is_active_tile(line, tile)) --tile;
    return tile;
}

// The number of blocks in a tile.
int blocks_of(int tile) { return (min(line_length - tile * TILE, TILE) + BLOCK - 1) / BLOCK; }

// The pixel i of a line, or the nearest one in the range.
Input input_in(int line, Run run, int i) {
    return input_at(pixel_at(line, clamp(i, run.start, run.end - 1)));
}

// A pixel, its predecessor, and the conductance between the two.
struct PixelPair {
    Input before, here;
    float b_in;
};

// Reads pixel i and its predecessor; nothing flows in before the first pixel of the range.
PixelPair pair_at(int line, Run run, int i) {
    PixelPair at;
    at.here = input_in(line, run, i);
    at.before = input_in(line, run, i - 1);
    at.b_in = i > run.start ? conductance(at.before, at.here) : 0.0;
    return at;
}

// Eliminates a pixel in one pole's network: r is its right-hand side, b_out the conductance to the next pixel.
void eliminate_pole(inout Carry carry, Input here, Value r, float b_out, int p, inout Eliminated removed) {
    Num to_next = flow(p, b_out), u = num(specific_heat(here)) + carry.heat[p];
    Value s = r + carry.source[p];
    Num inverse = inverted(u + to_next), w = mul(to_next, inverse);
    removed.s[p] = s;
    removed.inverse[p] = inverse;
    removed.w[p] = w;
    carry.source[p] = mul(w, s);
    carry.heat[p] = mul(w, u);
}

// Eliminates pixel i, and goes on to the next.
void eliminate(inout Carry carry, inout PixelPair at, int line, Run run, int i, inout Eliminated removed) {
    Input after = input_in(line, run, i + 1);
    float b_out = i + 1 < run.joined_end ? conductance(at.here, after) : 0.0;
    Source r = source_of(at.before, at.here, after, at.b_in, b_out);
    EACH_POLE(ELIMINATE_POLE)
    removed.here = at.here;
    at = PixelPair(at.here, after, b_out);
}

// The index of the state before the block of pixel i, for pole p.
int state_index(int slot, int i, int p) { return (slot * BLOCKS_PER_LINE + i / BLOCK) * POLES + p; }

// Sets the state to that before a pixel without a predecessor.
void clear_carry(out Carry carry) {
    EACH_POLE(CLEAR_CARRY_POLE)
}

// Adds the heat capacity of the repeated pixels before the line's first pixel.
void repeat_first(inout Carry carry, Input here) {
    Source r = source_of(here, here, here, 0.0, 0.0);
    EACH_POLE(REPEAT_FIRST_POLE)
}

// The solution right after the line's last pixel, with the value x of that pixel: one more pixel of heat capacity 1,
// and the repeated pixels `beyond` it.
Value repeat_end(Num heat, Value from_before, Num beyond, Value x) {
    Num whole = num(1.0) + beyond;
    return mul(inverted(heat + whole), from_before + mul(whole, x));
}

// Computes that solution for all poles.
void repeat_last(Carry carry, Input here, inout Value y[POLES]) {
    Source r = source_of(here, here, here, 0.0, 0.0);
    EACH_POLE(REPEAT_LAST_POLE)
}

// Stores the state before a block of pixels.
void save_carry(Carry carry, int slot, int i) {
    EACH_POLE(SAVE_POLE)
}

// Loads the state before a block of pixels.
void load_carry(out Carry carry, int slot, int i) {
    EACH_POLE(LOAD_POLE)
}

// Eliminates all active pixels of a line. y becomes the solution right after the last block; it is used only if a
// run reaches the line's end. The loops are `do ... while`, see shaders/README.md.
void eliminate_forward(int line, int slot, int tiles, out Value y[POLES]) {
    Carry carry;
    PixelPair at;
    Eliminated removed;
    EACH_POLE(CLEAR_POLE)
    int tile = next_active(line, 0, tiles);
    clear_carry(carry);
    if (IS_REPEATED && tile == 0) repeat_first(carry, input_in(line, run_of(line, 0), 0));
    if (tile < tiles) do {
        int blocks = blocks_of(tile), block = 0;
        Run run = run_of(line, tile);
        if (run.start > 0) clear_carry(carry);
        if (run.start == tile * TILE) at = pair_at(line, run, run.start);
        do {
            int first = tile * TILE + block * BLOCK, j = 0;
            save_carry(carry, slot, first);
            do eliminate(carry, at, line, run, first + j, removed); while (++j < BLOCK);
        } while (++block < blocks);
        tile = next_active(line, tile + 1, tiles);
    } while (tile < tiles);
    // A loop in place of an if: a software rasterizer runs both sides of every branch (shaders/README.md).
    for (int n = IS_REPEATED && is_active_tile(line, tiles - 1) ? 1 : 0; n > 0; --n) repeat_last(carry, at.here, y);
}

// Computes the solution of an eliminated pixel from y, that of the next pixel, and stores it if `is_inside`. y becomes
// the solution of this pixel.
void substitute(Eliminated removed, inout Value y[POLES], ivec2 at, bool is_inside) {
    Output o;
    clear_output(o);
    EACH_POLE(SUBSTITUTE_POLE)
    if (is_inside) store(at, removed.here, o);
}

// Computes and stores the solution of all active pixels of a line, from the last to the first.
void substitute_back(int line, int slot, int tiles, inout Value y[POLES]) {
    int tile = last_active(line, tiles - 1);
    if (tile >= 0) do {
        Run run = run_of(line, tile);
        int block = blocks_of(tile) - 1;
        do {
            int first = tile * TILE + block * BLOCK;
            Carry carry;
            load_carry(carry, slot, first);
            PixelPair at = pair_at(line, run, first);
            Eliminated removed[BLOCK];
            EACH_PIXEL(ELIMINATE_AGAIN)
            EACH_PIXEL_BACK(SUBSTITUTE)
        } while (--block >= 0);
        tile = last_active(line, tile - 1);
    } while (tile >= 0);
}

void main() {
    int slot = int(gl_GlobalInvocationID.x);
    if (slot >= line_count) return;
    int tiles = (line_length + TILE - 1) / TILE;
    Value y[POLES];
    eliminate_forward(first_line + slot, slot, tiles, y);
    substitute_back(first_line + slot, slot, tiles, y);
}

// Adapts a system that is not divided into parts to a strategy that solves in parts (shaders/README.md, "The contract
// of a SYSTEM"). The system has a single part with all its poles: `part` is always 0 and is dropped, and `pole` is
// passed on where the result depends on it. The input of a pixel is the same for every pole, and is its whole Link.

#define Link Input

Link link_at(ivec2 at) { return input_at(at); }
Input input_at(ivec2 at, int part, int pole) { return input_at(at); }
Value source(Source s, int part, int pole) { return source(s, pole); }
void add_pole(inout Output o, int part, int pole, Value y) { add_pole(o, pole, y); }
void store(ivec2 at, Link here, bool is_inside, inout Output o, int part) {
    if (is_inside) store(at, here, o);
}

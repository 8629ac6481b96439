// Where one surface ends in front of another, told from the circle of confusion alone: it is a
// straight line over 1/z, so differences and ratios of 1/z are those of coc - at_infinity_px.

uniform sampler2D coc_tx;
uniform float at_infinity_px;  // signed coc of what is infinitely far away

#define JUMP_PX 3.0       // less of a step in coc cannot be told from a slanted surface
#define DEPTH_RATIO 0.95  // and a surface nearer by less than this is the same surface

ivec2 inside(ivec2 at) { return clamp(at, ivec2(0), textureSize(coc_tx, 0) - 1); }
float coc_at(ivec2 at) { return texelFetch(coc_tx, inside(at), 0).r; }
float inverse_depth(float coc) { return at_infinity_px - coc; }  // up to a factor

bool is_in_front(float coc, float of) {
    return abs(coc - of) > JUMP_PX && inverse_depth(coc) * DEPTH_RATIO > inverse_depth(of);
}

// The kind of a pixel, and the coverage and the coc (signed circle of confusion, diameter in pixels, negative in front of
// the focus) of an edge pixel (lib/kind.lib.glsl), in the bits of one float: rays to highlights read it for many pixels,
// and would gather four textures otherwise (lib/highlight_rays.lib.glsl). highlight_ranges.comp.glsl writes it.
//
//   bit 31           1 in a far edge pixel
//   bit 30           1: the float is neither denormal nor infinite, whose bits a GPU may change
//   bits 29 to 16    a half: coverage of the near surface in an edge pixel, 1 in other pixels
//   bits 15 to 0     a half: coc of the near surface in a far edge pixel, of the far one in a near edge pixel, else 0

#define FAR_BIT 0x80000000u
#define SAFE_BIT 0x40000000u
#define COVER_BITS 0x3fffu
#define LISTED_WORD 0x7c007bffu  // the pixel's list begins with the visible surface: coverage 1, and no coc that occurs

float edge_word(float cover, float coc, bool is_far) {
    uint word = packHalf2x16(vec2(coc, cover)) | SAFE_BIT;
    return uintBitsToFloat(is_far ? word | FAR_BIT : word);
}

// The contents of a word.
bool is_far_edge(uint word) { return (word & FAR_BIT) != 0u; }
float edge_cover(uint word) { return unpackHalf2x16(word >> 16u & COVER_BITS).x; }
float edge_coc(uint word) { return unpackHalf2x16(word).x; }

// The same of four pixels.
vec4 edge_covers(uvec4 w) { return vec4(edge_cover(w.x), edge_cover(w.y), edge_cover(w.z), edge_cover(w.w)); }
vec4 edge_cocs(uvec4 w) { return vec4(edge_coc(w.x), edge_coc(w.y), edge_coc(w.z), edge_coc(w.w)); }

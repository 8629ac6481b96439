// Writes what is guessed behind one cut into the fragment lists. A cut is a gap in the depths of the picture, and the
// guess behind it extends all that is farther than the cut under all that is nearer (render/defocus/far_guess.py).
//
// The list of each pixel has one fragment for each cut, near to far. Where no surface behind the focus hides anything,
// the fragment receives NEAREST_DIOPTRES: it is then in front of the focus, and is not used.
//
// Inputs
//   coc_tx       r signed coc (circle of confusion, diameter in pixels, negative in front of the focus)
//   lib/guess_levels.lib.glsl   the pyramid of the guess, filled
// Outputs
//   start_buf     for each pixel, twice the number of its first fragment
//   fragment_buf  the fragments: color, coverage and dioptres, packed in WORDS words each

#include "lib/fragment_words.lib.glsl"  // WORDS, fragment_words
#include "lib/guess_levels.lib.glsl"  // is_known, coarser_at

layout(local_size_x = PIXEL_GROUP, local_size_y = PIXEL_GROUP) in;

uniform int first_row;        // first row of the band (render/defocus/pixel_list.py)
uniform sampler2D coc_tx;
uniform ivec4 coarser_rect;   // corner and size of level 1 of the pyramid
uniform int cut;              // number of this cut, near to far
uniform int cuts;             // number of cuts
uniform float cut_px;         // largest coc of a surface that hides the guess
uniform float least_px;       // coc above which a surface is behind the focus
uniform vec2 coc_line;        // signed coc at infinity, and per dioptre, pixels
layout(std430) writeonly buffer start_block { uint start_buf[]; };
layout(std430) writeonly buffer fragment_block { uint fragment_buf[]; };

#define NEAREST_DIOPTRES 1e9  // marks a fragment that is not used: nearer than everything

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy) + ivec2(0, first_row), size = textureSize(coc_tx, 0);
    if (any(greaterThanEqual(at, size))) return;
    uint pixel = uint(at.y * size.x + at.x), fragment = pixel * uint(cuts) + uint(cut);
    if (cut == 0) {  // starts are the same for all cuts; a start is stored times 2
        start_buf[pixel] = 2u * fragment;
        start_buf[pixel + 1u] = 2u * (fragment + uint(cuts));
    }
    float coc = texelFetch(coc_tx, at, 0).r;
    vec4 guess = coarser_at(at, coarser_rect);
    bool is_hidden = coc > least_px && coc <= cut_px && is_known(guess);
    uvec3 words = fragment_words(guess.rgb, 1.0, is_hidden ? (guess.a - coc_line.x) / coc_line.y : NEAREST_DIOPTRES);
    for (uint k = 0u; k < WORDS; ++k) fragment_buf[WORDS * fragment + k] = words[k];
}

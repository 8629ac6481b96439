// The surfaces along each pixel's ray behind the visible one, near to far, in one packed list. If a
// pixel shows several surfaces, each with its coverage, its list begins with the visible ones.
//
// start_buf     twice the start of a pixel's fragments, plus 1 if they begin with the visible surface;
//               an extra entry ends the last list
// fragment_buf  lib/fragment_words.lib.glsl

#include "lib/fragment_words.lib.glsl"
#include "lib/lean.lib.glsl"

layout(std430) readonly buffer start_block { uint start_buf[]; };
layout(std430) readonly buffer fragment_block { uint fragment_buf[]; };
uniform ivec2 lists_origin;   // index of the picture's first pixel, and pixels in a row, where the
uniform int lists_stride;     // lists cover more than the picture
uniform vec2 fragment_line;   // signed coc at infinity, and per dioptre, pixels
uniform bool is_open;         // the space behind a list's last fragment is empty: the plate has alpha
uniform bool is_alpha;        // the picture is the plate's alpha, which is 1 in every fragment

struct Fragment {
    vec3 color;
    float cover;  // 0..1 of the pixel
    float coc;    // signed, pixels
};

struct List {
    uint first, end;  // numbers of fragments
    bool has_front;
};

float list_lean = 0.0;  // of the pixel whose list was last asked for

List list_at(ivec2 at) {
    list_lean = lean_at(at);
    ivec2 place = lists_origin + at;
    uint pixel = uint(place.y * lists_stride + place.x), start = start_buf[pixel];
    return List(start >> 1, start_buf[pixel + 1u] >> 1, (start & 1u) == 1u);
}

Fragment fragment_of(uint number) {
    uint at = WORDS * number;
    vec2 red_green = unpackHalf2x16(fragment_buf[at]), blue_cover = unpackHalf2x16(fragment_buf[at + 1u]);
    float coc = fragment_line.x + fragment_line.y * uintBitsToFloat(fragment_buf[at + 2u]) + list_lean;
    return Fragment(is_alpha ? vec3(1.0) : vec3(red_green, blue_cover.x), blue_cover.y, coc);
}

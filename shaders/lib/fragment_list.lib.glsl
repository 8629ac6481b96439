// Reads fragment lists: for each pixel, the surfaces along its ray behind the visible one, near to far. Each surface
// is a fragment. If a pixel shows several surfaces, each with its coverage, its list begins with the visible ones.
//
// Inputs
//   start_buf      for each pixel, twice the number of its first fragment, plus 1 if the list begins with the visible
//                  surface. A list ends where the next one starts; an extra entry ends the last one.
//   fragment_buf   the fragments of all lists, one after the other (lib/fragment_words.lib.glsl)

#include "lib/fragment.lib.glsl"  // Fragment
#include "lib/fragment_words.lib.glsl"  // WORDS
#include "lib/focus_offset.lib.glsl"  // focus_offset_at
#include "lib/surface_depth.lib.glsl"  // fragment_line

layout(std430) readonly buffer start_block { uint start_buf[]; };
layout(std430) readonly buffer fragment_block { uint fragment_buf[]; };
uniform ivec2 lists_origin;   // position of the picture's first pixel among the pixels with lists
uniform int lists_stride;     // pixels with lists in a row
uniform bool is_open;         // the space behind a list's last fragment is empty: the plate has alpha
uniform bool is_alpha;        // the picture is the plate's alpha, which is 1 in every fragment

struct List {
    uint first, end;  // numbers of the first fragment, and of the one after the last
    bool has_front;   // the list begins with the visible surface
};

float list_focus_offset = 0.0;  // focus offset at the pixel of the last call of `list_at`

// The list of a pixel. Call this before `fragment_of`, which uses the focus offset that is set here.
List list_at(ivec2 at) {
    list_focus_offset = focus_offset_at(at);
    ivec2 list_position = lists_origin + at;
    uint pixel = uint(list_position.y * lists_stride + list_position.x), start = start_buf[pixel];
    return List(start >> 1, start_buf[pixel + 1u] >> 1, (start & 1u) == 1u);
}

// Unpacks a fragment of the list of the last call of `list_at`.
Fragment fragment_of(uint number) {
    uint at = WORDS * number;
    vec2 red_green = unpackHalf2x16(fragment_buf[at]), blue_cover = unpackHalf2x16(fragment_buf[at + 1u]);
    float coc = fragment_line.x + fragment_line.y * uintBitsToFloat(fragment_buf[at + 2u]) + list_focus_offset;
    return Fragment(is_alpha ? vec3(1.0) : vec3(red_green, blue_cover.x), blue_cover.y, coc);
}

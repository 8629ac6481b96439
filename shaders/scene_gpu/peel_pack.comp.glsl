// Moves the lists of a band, which peel_lists.comp.glsl made, to where they begin in the lists of the whole picture. Of a
// list for which memory has run out, what fits covers nothing.
//
// Inputs
//   group_buf      PEEL_LIST_WORDS for each pixel of the band: the length of its list, and three words a fragment
//   start_buf      twice the start of each pixel's list, plus 1 if it begins with the visible surface
//   depth_tx       planar depth of the picture, meters
//   first_row      first row of the band
//   end_row        the row after its last one
// Outputs
//   fragment_buf   three words a fragment (lib/fragment_words.lib.glsl)
//   out_depth_img  that of depth_tx, where memory has run out

#include "lib/fragment_words.lib.glsl"  // WORDS

#define COLOR_ONLY 0xffffu  // of the second word, all but the coverage

layout(local_size_x = PIXEL_GROUP, local_size_y = PIXEL_GROUP) in;

uniform int first_row;
uniform int end_row;
uniform sampler2D depth_tx;
layout(std430) readonly buffer group_block { uint group_buf[]; };
layout(std430) readonly buffer start_block { uint start_buf[]; };
layout(std430) writeonly buffer fragment_block { uint fragment_buf[]; };
layout(r32f) uniform writeonly image2D out_depth_img;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy), at = pixel + ivec2(0, first_row);
    ivec2 size = textureSize(depth_tx, 0);
    if (at.x >= size.x || at.y >= end_row) return;
    uint list = uint(PEEL_LIST_WORDS) * uint(pixel.y * size.x + pixel.x), index = uint(at.y * size.x + at.x);
    uint start = start_buf[index] >> 1, room = (start_buf[index + 1u] >> 1) - start;
    bool is_cut = room < group_buf[list];
    for (uint i = 0u; i < room; ++i) {
        uint from = list + 1u + WORDS * i, to = WORDS * (start + i), second = group_buf[from + 1u];
        fragment_buf[to] = group_buf[from];
        fragment_buf[to + 1u] = is_cut ? second & COLOR_ONLY : second;
        fragment_buf[to + 2u] = group_buf[from + 2u];
    }
    if (is_cut) imageStore(out_depth_img, at, texelFetch(depth_tx, at, 0));
}

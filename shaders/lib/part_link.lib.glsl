// The surfaces of the views through the parts of the lens, and the links of their lists: five words for each surface,
// found by the number of the surface plus 1. The surface is the same for all parts, and the link differs for each.
//   0  the next surface of the list: its number plus 1, 0 at the end
//   1  the position of the surface inside its cell, two values from 0 to 1, packed
//   2  coc of the surface; UNSEEN_PX if no view shows it
//   3  red and green, half floats
//   4  blue and coverage, half floats

#include "lib/fragment.lib.glsl"  // Fragment
#include "lib/fragment_words.lib.glsl"  // HALF_MOST

layout(std430) buffer link_block { uint link_buf[]; };

#define LINK_WORDS 5u
#define UNSEEN_PX -1e30

uint next_link(uint link) { return link_buf[LINK_WORDS * (link - 1u)]; }
vec2 link_offset(uint link) { return unpackUnorm2x16(link_buf[LINK_WORDS * (link - 1u) + 1u]); }
float link_coc(uint link) { return uintBitsToFloat(link_buf[LINK_WORDS * (link - 1u) + 2u]); }

// The color and the coverage of the surface.
vec4 link_light(uint link) {
    uint at = LINK_WORDS * (link - 1u) + 3u;
    return vec4(unpackHalf2x16(link_buf[at]), unpackHalf2x16(link_buf[at + 1u]));
}

void set_next_link(uint link, uint next) { link_buf[LINK_WORDS * (link - 1u)] = next; }

void write_link(uint link, uint next, vec2 offset) {
    set_next_link(link, next);
    link_buf[LINK_WORDS * (link - 1u) + 1u] = packUnorm2x16(offset);
}

// Marks a surface as one that no view shows.
void hide_surface(uint link) { link_buf[LINK_WORDS * (link - 1u) + 2u] = floatBitsToUint(UNSEEN_PX); }

void write_surface(uint link, Fragment surface) {
    uint at = LINK_WORDS * (link - 1u) + 2u;
    vec3 light = min(surface.color, HALF_MOST);
    link_buf[at] = floatBitsToUint(surface.coc);
    link_buf[at + 1u] = packHalf2x16(light.rg);
    link_buf[at + 2u] = packHalf2x16(vec2(light.b, surface.cover));
}

// Links of the lists of part_links.comp.glsl: three words for each surface, found by the number of the surface plus 1.
//   0  the next surface of the list: its number plus 1, 0 at the end
//   1  the position of the surface inside its cell, two values from 0 to 1, packed
//   2  its coc

layout(std430) buffer link_block { uint link_buf[]; };

#define LINK_WORDS 3u

uint next_link(uint link) { return link_buf[LINK_WORDS * (link - 1u)]; }
vec2 link_offset(uint link) { return unpackUnorm2x16(link_buf[LINK_WORDS * (link - 1u) + 1u]); }
float link_coc(uint link) { return uintBitsToFloat(link_buf[LINK_WORDS * (link - 1u) + 2u]); }

void set_next_link(uint link, uint next) { link_buf[LINK_WORDS * (link - 1u)] = next; }

void write_link(uint link, uint next, vec2 offset, float coc) {
    set_next_link(link, next);
    link_buf[LINK_WORDS * (link - 1u) + 1u] = packUnorm2x16(offset);
    link_buf[LINK_WORDS * (link - 1u) + 2u] = floatBitsToUint(coc);
}

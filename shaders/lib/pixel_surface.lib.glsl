// The surfaces that a pixel of the picture shows, in three words each: first the visible surface of each pixel, row by
// row, then for each the nearer surface that is mixed into it, with coverage 0 if there is none.
//   0  red and green, half floats
//   1  blue and coverage, half floats
//   2  signed coc in pixels, a float

#include "lib/fragment.lib.glsl"  // Fragment
#include "lib/fragment_words.lib.glsl"  // HALF_MOST

layout(std430) buffer pixel_surface_block { uint pixel_surface_buf[]; };

#define SURFACE_WORDS 3u

Fragment pixel_surface(uint number) {
    uint at = SURFACE_WORDS * number;
    vec2 red_green = unpackHalf2x16(pixel_surface_buf[at]), blue_cover = unpackHalf2x16(pixel_surface_buf[at + 1u]);
    return Fragment(vec3(red_green, blue_cover.x), blue_cover.y, uintBitsToFloat(pixel_surface_buf[at + 2u]));
}

void write_pixel_surface(uint number, Fragment surface) {
    uint at = SURFACE_WORDS * number;
    vec3 light = min(surface.color, HALF_MOST);
    pixel_surface_buf[at] = packHalf2x16(light.rg);
    pixel_surface_buf[at + 1u] = packHalf2x16(vec2(light.b, surface.cover));
    pixel_surface_buf[at + 2u] = floatBitsToUint(surface.coc);
}

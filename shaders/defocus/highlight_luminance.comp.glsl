// Computes the luminance from which the surroundings of highlights are made: highlights are light that is much
// brighter than its surroundings (lib/highlight_limit.lib.glsl). Surroundings are wide, so half the size is enough.
//
// Luminance is the mean of rgb. It is clipped, because a highlight must not raise the level that it is compared with.
// Bright surfaces are measured separately: where most of the surroundings are bright, nothing is a highlight.
//
// Inputs
//   color_tx          scene-linear rgb
//   coc_tx            r signed coc (circle of confusion, diameter in pixels, negative in front of the focus)
//   with LISTS: fragment lists (lib/fragment_list.lib.glsl)
// Outputs (one pixel for 2 x 2 of the picture)
//   out_luminance_img r mean luminance, clipped to 0..1
//                     g with LISTS the same of the brightest light in the lists; else the share of b that is not before
//                     the focus
//                     b share of light as bright as a bright surface can be, 0..1
//                     a with LISTS luminance of the brightest light in the lists, not clipped; else the share of pixels
//                     that are not before the focus
//   out_coc_img       r least diameter of the four, in pixels of this picture, so that sharp areas do not spread
//   lit_buf           0, for highlight_split.comp.glsl (lib/lit_bits.lib.glsl)

#ifdef LISTS
#include "lib/fragment_list.lib.glsl"  // List, list_at, fragment_of
#endif
#include "lib/highlight_limit.lib.glsl"  // surface_share, not_before_focus, mean_of
#include "lib/lit_bits.lib.glsl"  // lit_word, lit_buf

layout(local_size_x = PIXEL_GROUP, local_size_y = PIXEL_GROUP) in;

uniform int first_row;  // first row of the band (render/defocus/pixel_list.py)
uniform sampler2D color_tx;
uniform sampler2D coc_tx;
layout(rgba32f) uniform writeonly image2D out_luminance_img;
layout(r32f) uniform writeonly image2D out_coc_img;

#ifdef LISTS
// Luminance of the brightest light in the list of a pixel; 0 if the list is empty.
// The loop is a `do ... while`, see shaders/README.md.
float brightest_behind(ivec2 at) {
    List list = list_at(at);
    float brightest = 0.0;
    if (list.first < list.end) do {
        brightest = max(brightest, mean_of(fragment_of(list.first).color));
    } while (++list.first < list.end);
    return brightest;
}
#else
float brightest_behind(ivec2 at) { return 0.0; }
#endif

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy) + ivec2(0, first_row);
    if (any(greaterThanEqual(at, imageSize(out_luminance_img)))) return;
    ivec2 first = 2 * at, size = textureSize(color_tx, 0);
    // The first pixel of each block clears the block's two words.
    if (first.x % HIGHLIGHT_BLOCK == 0 && first.y % HIGHLIGHT_BLOCK == 0)
        for (int i = 0; i < 2; ++i) lit_buf[lit_word(first, size) + i] = 0u;
    float sum = 0.0, sum_behind = 0.0, brightest = 0.0, surface = 0.0, diameter = 1e30;
    vec2 behind_focus = vec2(0.0);  // light of surfaces, pixels
    for (int i = 0; i < 4; ++i) {
        ivec2 p = min(first + ivec2(i & 1, i >> 1), size - 1);
        float light = mean_of(texelFetch(color_tx, p, 0).rgb), behind = brightest_behind(p);
        sum += clamp(light, 0.0, 1.0);
        sum_behind += min(behind, 1.0);
        brightest = max(brightest, behind);
        surface += surface_share(max(light, behind));
        float coc = texelFetch(coc_tx, p, 0).r;
        behind_focus += not_before_focus(coc) * vec2(surface_share(light), 1.0);
        diameter = min(diameter, abs(coc));
    }
#ifdef LISTS
    imageStore(out_luminance_img, at, vec4(vec3(sum, sum_behind, surface) / 4.0, brightest));
#else
    imageStore(out_luminance_img, at, vec4(sum, behind_focus.x, surface, behind_focus.y) / 4.0);
#endif
    imageStore(out_coc_img, at, vec4(diameter / 2.0));
}

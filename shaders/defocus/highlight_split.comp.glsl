// Removes highlights, which are pixels much brighter than their surroundings, from the light to diffuse. They are drawn
// as discs instead (highlight_draw.frag.glsl); no light is lost. The reason: diffusion ripples by a few per cent, and a
// few per cent of a highlight may be brighter than the wall behind it.
//
// Inputs (coc: signed circle of confusion, diameter in pixels, negative in front of the focus)
//   color_tx           scene-linear rgb; a is copied
//   surroundings_tx    out_luminance_img of highlight_luminance.comp.glsl, diffused; one pixel for 2 x 2
//   luminance_tx       with LISTS: the same before it was diffused
//   coc_tx             r coc
// Outputs
//   out_diffuse_img       rgb light to diffuse, a of the picture
//   out_highlight_img  rgb removed light, a coc at which it is drawn; written for pixels with a highlight only
//   lit_buf            bits of these pixels (lib/lit_bits.lib.glsl); highlight_luminance.comp.glsl has set all to 0
//   out_around_img     r luminance of the surroundings, one pixel for 2 x 2, for hidden_fill.comp.glsl; NO_HIGHLIGHT
//                      on bright surfaces
//   diffuse_fragment_buf  with LISTS: a copy of the fragments, which lose their highlights here. A highlight behind the
//                      visible surface is put into out_highlight_img if no surface in front of it has one

#ifdef LISTS
#include "lib/fragment_list.lib.glsl"  // List, list_at, fragment_of, fragment_buf, Fragment, WORDS
#endif
#include "lib/highlight_limit.lib.glsl"  // NO_HIGHLIGHT, limit_of, surface_of, highlight_share, mean_of
#include "lib/lit_bits.lib.glsl"  // lit_word, lit_bit, lit_buf

layout(local_size_x = PIXEL_GROUP, local_size_y = PIXEL_GROUP) in;

uniform int first_row;  // first row of the band (render/defocus/pixel_list.py)
uniform sampler2D color_tx;
uniform sampler2D surroundings_tx;
uniform sampler2D coc_tx;
layout(rgba32f) uniform writeonly image2D out_diffuse_img;
layout(rgba32f) uniform writeonly image2D out_highlight_img;
layout(r16f) uniform writeonly image2D out_around_img;

#ifdef LISTS
uniform sampler2D luminance_tx;
layout(std430) writeonly buffer diffuse_fragment_block { uint diffuse_fragment_buf[]; };
#endif

// Discs smaller than LEAST_COC_PX stay pixels, those larger than WHOLE_COC_PX are drawn in full, with a
// smooth transition in between.
#define LEAST_COC_PX 0.25
#define WHOLE_COC_PX 0.75

#ifdef LISTS
uniform bool has_positions;         // the positions of lights in their pixels are known (highlight_sprites.comp.glsl)
#define KNOWN_POSITION_SCALE 0.4    // factor on both diameters then: discs are accurate from smaller sizes on

// Share of a highlight that is drawn as a disc if its disc has this diameter, 0 to 1; the rest is diffused.
float disc_share(float diameter) {
    float scale = has_positions ? KNOWN_POSITION_SCALE : 1.0;
    return smoothstep(scale * LEAST_COC_PX, scale * WHOLE_COC_PX, diameter);
}
#else
float disc_share(float diameter) { return smoothstep(LEAST_COC_PX, WHOLE_COC_PX, diameter); }
#endif

// Coc at which the highlight of a pixel is drawn. The mixed rim of a highlight has the depth of its neighbor, and so
// this is the coc of the brightest of 3 x 3 pixels; if not `is_searched`, the loop ends after one round and the result
// is not used.
float highlight_coc(ivec2 at, bool is_searched) {
    ivec2 last = textureSize(color_tx, 0) - 1;
    float most = mean_of(texelFetch(color_tx, at, 0).rgb);
    ivec2 brightest = at;
    int k = 0;
    do {
        ivec2 p = clamp(at + ivec2(k % 3, k / 3) - 1, ivec2(0), last);
        float luminance = mean_of(texelFetch(color_tx, p, 0).rgb);
        if (luminance > most) brightest = p;
        most = max(most, luminance);
    } while (is_searched && ++k < 9);
    return texelFetch(coc_tx, brightest, 0).r;
}

#ifdef LISTS
// A surface hides a light in highlight_draw.frag.glsl if it is nearer by MARGIN_PX of coc, and by the share
// MARGIN_SHARE of the coc of the light.
#define MARGIN_PX 2.0
#define MARGIN_SHARE 0.1
#define HIDDEN 0.02       // visible share of the pixel below which a fragment's light is drawn or lost

// Copies a fragment with another color; its coverage and dioptres stay.
void store_fragment(uint number, vec3 color) {
    uint at = WORDS * number;
    diffuse_fragment_buf[at] = packHalf2x16(color.rg);
    uint cover = fragment_buf[at + 1u] & 0xffff0000u;
    diffuse_fragment_buf[at + 1u] = cover | packHalf2x16(vec2(color.b, 0.0)) & 0xffffu;
    diffuse_fragment_buf[at + 2u] = fragment_buf[at + 2u];
}

// Share of a fragment's light that the fragments closely in front of it let through, which have a coc of `nearest_coc`
// or more. Drawing ignores these (highlight_draw.frag.glsl): every ray to the lens passes them close to the light, and
// so they cover the same share of the disc as of the pixel.
float transmission_past(List list, uint number, float nearest_coc) {
    float transmitted = 1.0;
    for (uint i = list.first; i < number; ++i) {
        Fragment fragment = fragment_of(i);
        if (fragment.coc >= nearest_coc) transmitted *= 1.0 - fragment.cover;
    }
    return transmitted;
}

// Takes the brightest light of the list that can be drawn into `highlight` (rgb light, a coc), and stores the list
// without its highlights. `highlight` may be that of the visible surface already, which stays then. `front_coc` is the
// coc of the visible surface, `around` and `surface` are the luminance of the surroundings and their degree of being a
// bright surface.
void split_list(ivec2 at, float front_coc, float around, float surface, inout vec4 highlight) {
    List list = list_at(at);
    if (list.has_front) highlight.rgb = vec3(0.0);  // the list has the visible surface's highlight too
    bool may_draw = mean_of(highlight.rgb) == 0.0;  // a pixel draws one highlight; a visible one keeps those behind out
    if (texelFetch(luminance_tx, at >> 1, 0).a <= limit_of(around)) list.end = list.first;  // nothing is bright
    float uncovered = list.has_front ? 1.0 : 0.0;  // share of the pixel not covered by the fragments so far
    for (uint i = list.first; i < list.end; ++i) {
        Fragment fragment = fragment_of(i);
        // Share of the fragment's light that is a highlight and would be drawn.
        float drawn_share = disc_share(abs(fragment.coc)) * (1.0 - surface) * highlight_share(fragment.color, around);
        float margin = max(MARGIN_PX, MARGIN_SHARE * abs(fragment.coc));
        vec3 light = drawn_share * fragment.color, drawn_light = fragment.cover * light;
        if (drawn_share > 0.0) drawn_light *= transmission_past(list, i, fragment.coc - margin);
        bool is_front = list.has_front && i == list.first, is_hidden = uncovered < HIDDEN;
        // Closer behind the visible surface than the margin, a light would be drawn as if nothing hid it.
        bool is_apart = is_front || fragment.coc - front_coc > margin;
        bool is_drawn = may_draw && is_apart && mean_of(drawn_light) > mean_of(highlight.rgb);
        if (is_drawn) highlight = vec4(drawn_light, fragment.coc);
        if (is_drawn && !is_hidden) may_draw = false;
        store_fragment(i, is_drawn || is_hidden ? fragment.color - light : fragment.color);
        uncovered *= 1.0 - fragment.cover;
    }
}
#endif

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy) + ivec2(0, first_row);
    if (any(greaterThanEqual(at, textureSize(color_tx, 0)))) return;
    vec4 x = texelFetch(color_tx, at, 0);
    float coc = texelFetch(coc_tx, at, 0).r;
    vec4 surroundings = texelFetch(surroundings_tx, at >> 1, 0);
    // drawn_share: share of the pixel's light that is removed and drawn.
    float around = surroundings.r, surface = surface_of(surroundings.b);
    float drawn_share = (1.0 - surface) * highlight_share(x.rgb, around), lamp_coc = coc;
    float brightest_coc = highlight_coc(at, drawn_share > 0.0);
    if (drawn_share > 0.0) {
        lamp_coc = brightest_coc;
        drawn_share *= disc_share(max(abs(coc), abs(lamp_coc)));
    }
    vec4 highlight = vec4(drawn_share * x.rgb, lamp_coc);
    imageStore(out_diffuse_img, at, vec4(x.rgb - drawn_share * x.rgb, x.a));
#ifdef LISTS
    split_list(at, coc, max(surroundings.g, around), surface, highlight);
#endif
    if (highlight.rgb != vec3(0.0)) {
        imageStore(out_highlight_img, at, highlight);
        atomicOr(lit_buf[lit_word(at, textureSize(color_tx, 0))], lit_bit(at));
    }
    imageStore(out_around_img, at >> 1, vec4(mix(around, NO_HIGHLIGHT, surface)));
}

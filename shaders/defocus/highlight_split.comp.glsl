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
#include "lib/highlight_limit.lib.glsl"  // NO_HIGHLIGHT, limit_of, surface_of, not_before_focus, highlight_share, mean_of
#include "lib/highlight_rim.lib.glsl"  // Seen, look_around, is_beside_nearer, share_of, rim_of, color_tx, coc_tx
#ifdef LISTS
#include "lib/highlights.lib.glsl"  // margin_of
#endif
#include "lib/lit_bits.lib.glsl"  // lit_word, lit_bit, lit_buf

layout(local_size_x = PIXEL_GROUP, local_size_y = PIXEL_GROUP) in;

uniform int first_row;  // first row of the band (render/defocus/pixel_list.py)
uniform sampler2D surroundings_tx;
layout(rgba32f) uniform writeonly image2D out_diffuse_img;
layout(rgba32f) uniform writeonly image2D out_highlight_img;
layout(r16f) uniform writeonly image2D out_around_img;

#ifdef LISTS
uniform sampler2D luminance_tx;
layout(std430) writeonly buffer diffuse_fragment_block { uint diffuse_fragment_buf[]; };
#endif

// Discs smaller than LEAST_COC_PX stay pixels, those larger than WHOLE_COC_PX are drawn in full, with a
// smooth transition in between.
#define LEAST_COC_PX 0.02
#define WHOLE_COC_PX 0.1
#define LEAST_BEHIND 0.02  // share of the surroundings that must not be before the focus, to tell what is there

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

// Share of a highlight that is no part of a bright surface, 0..1. `surface` is the degree to which its surroundings are
// one, `brightest` the luminance of the brightest light around it.
float apart_from(float surface, float brightest) { return 1.0 - surface * surface_share(brightest); }

#ifdef LISTS
#define HIDDEN 0.02       // visible share of the pixel below which a fragment's light is drawn or lost
#define SAME_COC_PX 0.5   // coc within this difference, or this share of the coc, belong to one surface
#define SAME_COC_SHARE 0.05
#define NOT_FOUND 1e30
#define RIM_SHARE 0.5     // the surface of a rim has less than this share of its light beside it

// The brightest light around a pixel, in the picture and in the lists of 3 x 3 pixels: its luminance and its coc.
vec2 brightest_around(ivec2 at) {
    ivec2 last = textureSize(color_tx, 0) - 1;
    vec2 brightest = vec2(0.0);
    for (int k = 0; k < 9; ++k) {
        ivec2 p = clamp(at + ivec2(k % 3, k / 3) - 1, ivec2(0), last);
        vec2 light = vec2(mean_of(texelFetch(color_tx, p, 0).rgb), texelFetch(coc_tx, p, 0).r);
        if (light.x > brightest.x) brightest = light;
        List list = list_at(p);
        for (uint i = list.first; i < list.end; ++i) {
            Fragment fragment = fragment_of(i);
            light = vec2(mean_of(fragment.color), fragment.coc);
            if (light.x > brightest.x) brightest = light;
        }
    }
    return brightest;
}

// A luminance that the brightest light around does not exceed, without a search through the lists. If not `is_searched`,
// the loop ends after one round and the result is not used.
float most_around(ivec2 at, bool is_searched) {
    ivec2 last = textureSize(color_tx, 0) - 1, last_of_half = textureSize(luminance_tx, 0) - 1;
    ivec4 halves = ivec4((at - 1) >> 1, (at + 1) >> 1);  // all that touch 3 x 3 pixels
    float most = 0.0;
    int k = 0;
    do {
        ivec2 p = clamp(at + ivec2(k % 3, k / 3) - 1, ivec2(0), last);
        most = max(most, mean_of(texelFetch(color_tx, p, 0).rgb));
    } while (is_searched && ++k < 9);
    for (int i = 0; i < 4; ++i) {
        ivec2 p = clamp(ivec2(halves[i & 2], halves[1 + (i & 1) * 2]), ivec2(0), last_of_half);
        most = max(most, texelFetch(luminance_tx, p, 0).a);
    }
    return most;
}

// How the surface of a light goes on in 3 x 3 pixels.
struct Surrounding {
    float least;  // luminance
    int pixels;   // in which the surface is
};
Surrounding surrounding_of(ivec2 at, float luminance, float coc) {
    ivec2 last = textureSize(color_tx, 0) - 1;
    float same = max(SAME_COC_PX, SAME_COC_SHARE * abs(coc));
    Surrounding result = Surrounding(luminance, 0);
    for (int k = 0; k < 9; ++k) {
        ivec2 p = clamp(at + ivec2(k % 3, k / 3) - 1, ivec2(0), last);
        float found = abs(texelFetch(coc_tx, p, 0).r - coc) <= same ? mean_of(texelFetch(color_tx, p, 0).rgb) : NOT_FOUND;
        List list = list_at(p);
        for (uint i = list.first; i < list.end; ++i) {
            Fragment fragment = fragment_of(i);
            if (abs(fragment.coc - coc) <= same) found = min(found, mean_of(fragment.color));
        }
        result.least = min(result.least, found);
        result.pixels += found < NOT_FOUND ? 1 : 0;
    }
    return result;
}

// The lamp that a light comes from.
struct Lamp {
    float share;     // of the light that is the lamp's
    float coc;
    bool is_hidden;  // by the surface that it is on
};

// The lamp of a highlight of the share `share` on a surface with this coc, visible or hidden. A lamp has its light in all
// of its pixels. Where the surface goes on beside the pixel with less light, the pixel is the rim of a lamp that is
// another surface, that of the `brightest` light around: what exceeds the surface's own light is the lamp's. It is hidden
// where the surface is in front of the lamp and goes on to all sides.
Lamp lamp_of(ivec2 at, vec3 color, float coc, float share, vec2 brightest) {
    float luminance = mean_of(color);
    if (share <= 0.0 || luminance >= brightest.x) return Lamp(share, coc, false);
    Surrounding surrounding = surrounding_of(at, luminance, coc);
    if (surrounding.least >= RIM_SHARE * luminance) return Lamp(share, coc, false);
    return Lamp(1.0 - surrounding.least / luminance, brightest.y, brightest.y > coc && surrounding.pixels == 9);
}

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
    float least = texelFetch(luminance_tx, at >> 1, 0).a;  // the brightest light around is at least as bright
    if (least <= limit_of(around)) list.end = list.first;  // nothing is bright
    bool may_be_surface = list.first < list.end && surface >= 1.0 && least > 1.0;
    if (may_be_surface && most_around(at, may_be_surface) <= LAMP_FROM) list.end = list.first;  // all of it is a surface
    vec2 brightest = list.first < list.end ? brightest_around(at) : vec2(0.0);
    list_focus_offset = focus_offset_at(at);  // the search has changed it
    float uncovered = list.has_front ? 1.0 : 0.0;  // share of the pixel not covered by the fragments so far
    for (uint i = list.first; i < list.end; ++i) {
        Fragment fragment = fragment_of(i);
        Lamp lamp = Lamp(highlight_share(fragment.color, around), fragment.coc, false);
        // A list that begins with the visible surface has each light at its own depth: there are no rims.
        if (!list.has_front) lamp = lamp_of(at, fragment.color, fragment.coc, lamp.share, brightest);
        list_focus_offset = focus_offset_at(at);
        // Share of the fragment's light that is a highlight and would be drawn.
        float coc = lamp.coc, drawn_share = lamp.share * apart_from(surface, brightest.x);
        if (!lamp.is_hidden) drawn_share *= disc_share(max(abs(fragment.coc), abs(coc)));
        float margin = margin_of(coc);  // a surface nearer by more hides the light in highlight_draw.frag.glsl
        vec3 light = drawn_share * fragment.color, drawn_light = fragment.cover * light;
        if (drawn_share > 0.0) drawn_light *= transmission_past(list, i, coc - margin);
        bool is_front = list.has_front && i == list.first, is_hidden = uncovered < HIDDEN;
        // Closer behind the visible surface than the margin, a light would be drawn as if nothing hid it.
        bool is_apart = is_front || coc - front_coc > margin;
        bool is_drawn = may_draw && is_apart && !lamp.is_hidden && mean_of(drawn_light) > mean_of(highlight.rgb);
        if (is_drawn) highlight = vec4(drawn_light, coc);
        if (is_drawn && !is_hidden) may_draw = false;
        store_fragment(i, is_drawn || is_hidden || lamp.is_hidden ? fragment.color - light : fragment.color);
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
    float drawn_share = share_of(at, vec4(x.rgb, coc), around), lamp_coc = coc;
    bool is_rim = is_beside_nearer(at, coc);
    Seen seen = look_around(at, coc, drawn_share > 0.0 || is_rim);
    vec2 brightest = vec2(mean_of(seen.brightest.rgb), seen.brightest.a);
    vec4 rim = is_rim ? rim_of(x.rgb, coc, seen, around) : vec4(0.0);  // rgb light of a nearer thing, a its coc
    rim.rgb *= apart_from(surface, brightest.x) * disc_share(max(abs(coc), abs(brightest.y)));
    float surface_behind = surface;
#ifndef LISTS
    surface_behind = max(surface, surface_of(surroundings.g / max(surroundings.a, LEAST_BEHIND)));
    surface = mix(surface, surface_behind, not_before_focus(coc));
#endif
    if (drawn_share > 0.0) {
        lamp_coc = brightest.y;
#ifdef LISTS
        vec2 brightest_of_all = brightest_around(at);
        if (brightest_of_all.x > brightest.x) {
            Lamp lamp = lamp_of(at, x.rgb, coc, drawn_share, brightest_of_all);
            if (lamp.coc != coc) lamp_coc = lamp.coc;
            brightest = brightest_of_all;
        }
#endif
        drawn_share *= apart_from(surface, brightest.x) * disc_share(max(abs(coc), abs(lamp_coc)));
    }
    vec4 highlight = vec4(drawn_share * x.rgb, lamp_coc);
    if (mean_of(rim.rgb) > mean_of(highlight.rgb)) highlight = rim;
    imageStore(out_diffuse_img, at, vec4(x.rgb - highlight.rgb, x.a));
#ifdef LISTS
    split_list(at, coc, max(surroundings.g, around), surface, highlight);
#endif
    if (highlight.rgb != vec3(0.0)) {
        imageStore(out_highlight_img, at, highlight);
        atomicOr(lit_buf[lit_word(at, textureSize(color_tx, 0))], lit_bit(at));
    }
    imageStore(out_around_img, at >> 1, vec4(mix(around, NO_HIGHLIGHT, surface_behind)));
}

// Draws a quad around the disc of each highlight, and finds the nearest surface that a ray from the lens to the
// highlight may meet. highlight_draw.frag.glsl need not look for nearer ones. Nothing is drawn of a highlight of a listed
// surface where all that is visible around it, as far as rays to it go, is nearer and hides it. (coc: signed circle of confusion,
// diameter in pixels, negative in front of the focus.)
//
// Inputs
//   in_disc, in_light   the highlight: a Sprite of lib/highlights.lib.glsl
//   coc_range_tx         r least coc of each tile, g greatest one of its visible surfaces
// Outputs
//   disc, light         the same as in_disc and the rgb of in_light
//   may_meet_px          least coc that a ray may meet

#include "lib/aperture.lib.glsl"  // aperture_reach
#include "lib/highlights.lib.glsl"  // margin_of

in vec4 in_disc;   // center x, y in pixels; signed coc; half the width of the rim's ramp
in vec4 in_light;  // rgb of a pixel wholly inside

uniform vec2 picture_size;

flat out vec4 disc;
flat out vec3 light;
flat out float may_meet_px;  // least signed coc

uniform sampler2D coc_range_tx;  // from tile_layers.comp.glsl
uniform float nearest_px;      // least coc of the picture
uniform vec2 rows;             // first row of the band that is drawn, and the row after its last, pixels of the picture

#define FARTHEST_PX 1e30
#define TILES_MOST 24  // largest number of tiles to read in a row
#define OUTSIDE 2.0    // outside the picture, where nothing is drawn
#define LOOKUP_PX 3.0  // added to the reach: the fragment shader reads 2 x 2 pixels, which know of surfaces beside them

// Least signed coc of the tiles within `reach` of a position, and greatest one of their visible surfaces; the least of the
// picture, and the greatest of all, if there are too many tiles.
vec2 coc_range_within(vec2 center, vec2 reach) {
    ivec2 last_tile = textureSize(coc_range_tx, 0) - 1;
    ivec2 first = clamp(ivec2(floor((center - reach) / float(TILE))), ivec2(0), last_tile);
    ivec2 last = clamp(ivec2(floor((center + reach) / float(TILE))), ivec2(0), last_tile);
    if (any(greaterThan(last - first, ivec2(TILES_MOST)))) return vec2(nearest_px, FARTHEST_PX);
    vec2 range = vec2(FARTHEST_PX, -FARTHEST_PX);
    for (int y = first.y; y <= last.y; ++y)
        for (int x = first.x; x <= last.x; ++x) {
            vec2 of_tile = texelFetch(coc_range_tx, ivec2(x, y), 0).rg;
            range = vec2(min(range.x, of_tile.x), max(range.y, of_tile.y));
        }
    return range;
}

void main() {
    disc = in_disc;
    light = in_light.rgb;
    vec2 corner = vec2(gl_VertexID % 2, gl_VertexID / 2) * 2.0 - 1.0;
    vec2 reach = aperture_reach(0.5 * in_disc.z, in_disc.w) + 1.0;
    vec2 at = in_disc.xy + corner * reach;
    // At the nearest depth, rays to the disc lie within the disc's reach times `wider`.
    float coc = in_disc.z, wider = max(coc - nearest_px, 0.0) / max(abs(coc), 1e-3);
    bool is_drawn = in_disc.y + reach.y >= rows.x && in_disc.y - reach.y <= rows.y;
    // A disc outside the band needs no search: its reach is 0.
    vec2 range = coc_range_within(in_disc.xy, reach * (is_drawn ? max(wider, 1.0) : 0.0) + LOOKUP_PX);
    may_meet_px = range.x;
    bool is_hidden = range.y < coc - margin_of(coc);
    gl_Position = vec4(is_hidden ? vec2(OUTSIDE) : at / picture_size * 2.0 - 1.0, 0.0, 1.0);
}

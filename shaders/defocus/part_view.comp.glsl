// Draws the view through one part of the lens: the surfaces that have moved to each pixel (part_links.comp.glsl) are
// composited near to far. Surfaces at about the same depth add up to one. With ALL_DEPTHS, what is in front of the focus is
// drawn into a picture of its own, because its blur spreads over what is in focus.
//
// A later pass blurs the view with the disc of the part. A moved surface lies between four pixels, and counts in each
// of them with its bilinear weight. The known share of a pixel is the share that its surfaces cover.
//
// Inputs
//   coc_tx        r signed coc of the picture, pixels; only its size is used
//   limit_buf     limits of each pixel (part_surfaces.comp.glsl)
//   head_buf, lib/part_link.lib.glsl   the lists of the cells between pixels (part_links.comp.glsl), near to far
//   lib/lens_part.lib.glsl       the part of the lens
//   lib/tile_numbers.lib.glsl    the tiles in which the view is needed
// Outputs
//   lib/view_marks.lib.glsl      the tiles in which the view is blurred
//   view_buf      half floats of each pixel, row by row: rgb, a 1; all 0 where nothing is known
//   out_coc_img    r diameter of the part's disc in pixels: that of the most visible surface, or, where nothing is
//                  known, of the pixel's own surface
//   front_buf            ALL_DEPTHS: half floats of what is in front of the focus: rgb times coverage, a coverage
//   out_front_state_img  ALL_DEPTHS: r diameter of the part's disc there, g coverage

#include "lib/surface_depth.lib.glsl"  // dioptres_of, SAME_SURFACE, COVERING, ALL_PX
#include "lib/halves.lib.glsl"  // halves_of
#include "lib/lens_part.lib.glsl"  // lens_part_at
#include "lib/part_link.lib.glsl"  // next_link, link_offset, link_coc, link_light
#include "lib/tile_numbers.lib.glsl"  // listed_pixel
#include "lib/view_marks.lib.glsl"  // set_mark, IS_BLURRED, HAS_FRONT

layout(local_size_x = TILE, local_size_y = TILE) in;

uniform sampler2D coc_tx;
layout(std430) readonly buffer head_block { uint head_buf[]; };
layout(std430) readonly buffer limit_block { vec2 limit_buf[]; };
layout(std430) writeonly buffer view_block { uvec2 view_buf[]; };
layout(r32f) uniform writeonly image2D out_coc_img;
#ifdef ALL_DEPTHS
layout(std430) writeonly buffer front_block { uvec2 front_buf[]; };
layout(rg32f) uniform writeonly image2D out_front_state_img;
uniform float front_px;  // a surface with a smaller coc is in front of the focus
#endif

#define SAME_IF_WHOLE 1.003  // ratio of dioptres up to which surfaces are one, if the first covers the pixel
#define WHOLE 0.999          // share from which a surface covers the pixel wholly
#define GAIN 1.1             // shares of a stretched surface sum to a little less than 1, and are raised by this
#define EDGE_MOST 0.6        // shares up to this are those at an edge of a surface, and stay
#define LEAST_SHARE 1e-4     // smaller shares of a pixel are ignored
#define LEAST_KNOWN 0.02     // least known share of a pixel with a view
#define BLURRED_FROM_PX 0.75  // smaller discs are not seen

// The next surface of each of the four cells around the pixel, which are merged near to far: its number plus 1, 0 at the
// end of the list, and its coc. Bit 0 of the index is set for the cells after the pixel in x, bit 1 for those in y.
uvec4 next_links;
vec4 next_cocs;

void set_next(int k, uint link) {
    next_links[k] = link;
    next_cocs[k] = link == 0u ? ALL_PX : link_coc(link);
}

// Index of the cell whose next surface is the nearest. Of equal surfaces it is the one with the smaller number, because
// the sum must not depend on the order in which they were linked.
int nearest_cell() {
    int nearest = 0;
    for (int k = 1; k < 4; ++k) {
        bool is_nearer = next_cocs[k] < next_cocs[nearest];
        if (is_nearer || next_cocs[k] == next_cocs[nearest] && next_links[k] < next_links[nearest]) nearest = k;
    }
    return nearest;
}

// Share of the pixel that the next surface of cell `k` has by its position, 0 to 1.
float share_of_next(int k) {
    vec2 offset = link_offset(next_links[k]);
    vec2 weights = mix(offset, 1.0 - offset, bvec2(k & 1, k >> 1));
    return weights.x * weights.y;
}

struct View {
    vec4 light;   // rgb times the known share so far, a that share
    float coc;    // coc of the most visible surface
    float largest_share;   // share of that surface
};

// The share of a pixel that a surface covers, from the sum of its shares.
float cover_of(float share) { return min(share * mix(1.0, GAIN, smoothstep(EDGE_MOST, COVERING, share)), 1.0); }

// Composites a surface (rgb times its share of the pixel, a the share) behind the view so far.
void put_behind(inout View view, vec4 surface, float coc) {
    float cover = cover_of(surface.a) * (1.0 - view.light.a);
    view.light += cover * vec4(surface.rgb / max(surface.a, LEAST_SHARE), 1.0);
    if (cover > view.largest_share) view.coc = coc;
    view.largest_share = max(view.largest_share, cover);
}

// True if a surface is drawn into the picture of what is in front of the focus.
bool is_in_front(float coc) {
#ifdef ALL_DEPTHS
    return coc < front_px;
#else
    return false;
#endif
}

const View EMPTY = View(vec4(0.0), 0.0, 0.0);
View front = EMPTY;  // with ALL_DEPTHS, what is in front of the focus

// Composites a surface behind the view so far, or behind what is in front of the focus so far.
void put_on_its_side(inout View view, vec4 surface, float coc) {
    if (is_in_front(coc)) {
        put_behind(front, surface, coc);
        return;
    }
    put_behind(view, surface, coc);
}

// Composites the surfaces of the pixel near to far, until they cover it or reach `end_coc`.
View composite_surfaces(float end_coc) {
    View view = EMPTY;
    vec4 surface = vec4(0.0);  // the sum of surfaces at about one depth: rgb times share, a share
    float first_coc = 0.0, dioptres = 0.0;  // of the first of these
    // What lies behind a surface that covers the pixel is not seen.
    while (view.light.a < 1.0 && (surface.a < WHOLE || is_in_front(first_coc))) {
        int k = nearest_cell();
        float coc = next_cocs[k];
        if (coc >= end_coc) break;
        uint link = next_links[k];
        vec4 light = link_light(link);
        float share = share_of_next(k) * light.a;
        set_next(k, next_link(link));
        if (share <= LEAST_SHARE) continue;
        float own_dioptres = dioptres_of(coc);
        float tolerance = surface.a > COVERING ? SAME_IF_WHOLE : SAME_SURFACE;
        if (surface.a > 0.0 && own_dioptres * tolerance < dioptres) {
            put_on_its_side(view, surface, first_coc);
            surface = vec4(0.0);
        }
        if (surface.a == 0.0) { first_coc = coc; dioptres = own_dioptres; }
        surface += share * vec4(light.rgb, 1.0);
    }
    if (surface.a > 0.0) put_on_its_side(view, surface, first_coc);
    return view;
}

void main() {
    ivec2 at = listed_pixel();
    ivec2 size = textureSize(coc_tx, 0);
    if (any(greaterThanEqual(at, size))) return;
    int cells_across = size.x + 1, cell = at.y * cells_across + at.x, pixel = cell - at.y;
    for (int k = 0; k < 4; ++k) set_next(k, head_buf[cell + (k >> 1) * cells_across + (k & 1)]);
    vec2 limits = limit_buf[pixel];
    View view = composite_surfaces(limits.y);
    bool is_known = view.light.a > LEAST_KNOWN;
    view_buf[pixel] = is_known ? halves_of(vec4(view.light.rgb / view.light.a, 1.0)) : uvec2(0u);
    float part_scale = lens_part_at(at, size).z;
    float coc = is_known ? view.coc : limits.x;
    imageStore(out_coc_img, at, vec4(part_scale * abs(coc)));
    if (part_scale * abs(coc) > BLURRED_FROM_PX) set_mark(at / TILE, IS_BLURRED);
#ifdef ALL_DEPTHS
    front_buf[pixel] = halves_of(front.light);
    if (front.light.a > 0.0) set_mark(at / TILE, HAS_FRONT);
    imageStore(out_front_state_img, at, vec4(part_scale * abs(front.coc), front.light.a, 0.0, 0.0));
#endif
}

// Draws the view through one part of the lens: the surfaces that have moved to each pixel (part_links.comp.glsl) are
// composited near to far. Surfaces at about the same depth add up to one. With ALL_DEPTHS, what is in front of the focus is
// drawn into a picture of its own, because its blur spreads over what is in focus.
//
// A later pass blurs the view with the disc of the part. A moved surface lies between four pixels, and counts in each
// of them with its bilinear weight. The known share of a pixel is the share that its surfaces cover.
//
// Inputs
//   lib/part_surfaces.lib.glsl   the surfaces, by number; coc is their diameter of blur in pixels
//   head_buf, link_buf           the lists of the cells between pixels, see part_links.comp.glsl
//   lib/lens_part.lib.glsl       the part of the lens
//   lib/tile_mask.lib.glsl       the tiles in which the view is needed
// Outputs
//   out_view_img   rgb, a 1; all 0 where nothing is known
//   out_coc_img    r diameter of the part's disc in pixels: that of the most visible surface, or, where nothing is
//                  known, of the pixel's own surface
//   out_front_img        ALL_DEPTHS: rgb times coverage, a coverage of what is in front of the focus
//   out_front_state_img  ALL_DEPTHS: r diameter of the part's disc there, g coverage

#include "lib/part_surfaces.lib.glsl"
#include "lib/lens_part.lib.glsl"
#include "lib/tile_mask.lib.glsl"

layout(local_size_x = PIXEL_GROUP, local_size_y = PIXEL_GROUP) in;

uniform int first_row;  // first row of the band (render/defocus/pixel_list.py)
layout(std430) readonly buffer head_block { uint head_buf[]; };
layout(std430) readonly buffer link_block { uvec2 link_buf[]; };
layout(rgba32f) uniform writeonly image2D out_view_img;
layout(r32f) uniform writeonly image2D out_coc_img;
#ifdef ALL_DEPTHS
layout(rgba32f) uniform writeonly image2D out_front_img;
layout(rg32f) uniform writeonly image2D out_front_state_img;
uniform float front_px;  // a surface with a smaller coc is in front of the focus
#endif

#define SURFACES_MAX 24      // surfaces kept for a pixel; if there are more, the nearest
#define SAME_IF_WHOLE 1.003  // ratio of dioptres up to which surfaces are one, if the first covers the pixel
#define GAIN 1.1             // shares of a stretched surface sum to a little less than 1
#define ALL_PX 1e30            // larger than every coc
#define LEAST_SHARE 1e-4     // smaller shares of a pixel are ignored
#define LEAST_KNOWN 0.02     // least known share of a pixel with a view

// The surfaces of the pixel, near to far.
uint numbers[SURFACES_MAX];   // their numbers in lib/part_surfaces.lib.glsl
vec2 surfaces[SURFACES_MAX];  // coc and share of the pixel
int count;                    // how many there are

// Inserts a surface into the list of the pixel, near to far; if the list is full, the farthest is dropped. Surfaces of
// the same coc are in the order of their numbers, because the sum must not depend on the order in which they were
// linked.
void keep_surface(uint number, float coc, float share) {
    int slot = min(count, SURFACES_MAX - 1);
    bool fits = count < SURFACES_MAX || coc < surfaces[slot].x || coc == surfaces[slot].x && number < numbers[slot];
    if (!fits) return;
    count = min(count + 1, SURFACES_MAX);
    for (; slot > 0; --slot) {
        vec2 other = surfaces[slot - 1];
        if (other.x < coc || other.x == coc && numbers[slot - 1] < number) break;
        surfaces[slot] = other;
        numbers[slot] = numbers[slot - 1];
    }
    surfaces[slot] = vec2(coc, share);
    numbers[slot] = number;
}

// Inserts all surfaces of a cell, with their shares of the pixel. `is_before` tells for x and y whether the cell lies
// before the pixel, or after it.
void keep_cell(ivec2 cell, bvec2 is_before) {
    ivec2 cells = textureSize(coc_tx, 0) + 1;
    for (uint link = head_buf[cell.y * cells.x + cell.x]; link != 0u; link = link_buf[link - 1u].x) {
        vec2 offset = unpackUnorm2x16(link_buf[link - 1u].y);
        vec2 weights = mix(1.0 - offset, offset, vec2(is_before));
        Fragment fragment = surface_number(link - 1u);
        float share = weights.x * weights.y * fragment.cover;
        if (share > LEAST_SHARE) keep_surface(link - 1u, fragment.coc, share);
    }
}

struct View {
    vec4 light;   // rgb times the known share so far, a that share
    float coc;    // coc of the most visible surface
    float largest_share;   // share of that surface
};

// Composites a surface (rgb times its share of the pixel, a the share) behind the view so far.
void put_behind(inout View view, vec4 surface, float coc) {
    float cover = min(surface.a * GAIN, 1.0) * (1.0 - view.light.a);
    view.light += cover * vec4(surface.rgb / max(surface.a, LEAST_SHARE), 1.0);
    if (cover > view.largest_share) view.coc = coc;
    view.largest_share = max(view.largest_share, cover);
}

#ifdef ALL_DEPTHS
// True if all known surfaces of a pixel are in front of the focus: nothing is known of what they hide. What is far
// behind moves there from pixels beside it, although a nearer surface, which is not known here, would hide it.
bool is_hole(ivec2 at) {
    List list = list_at(at);
    float last_coc = list.first < list.end ? fragment_of(list.end - 1u).coc : texelFetch(coc_tx, at, 0).r;
    return last_coc < front_px;
}
#endif

const View EMPTY = View(vec4(0.0), 0.0, 0.0);
View front = EMPTY;  // with ALL_DEPTHS, what is in front of the focus

// Composites a surface behind the view so far, or behind what is in front of the focus so far.
void put_on_its_side(inout View view, vec4 surface, float coc) {
#ifdef ALL_DEPTHS
    if (coc < front_px) {
        put_behind(front, surface, coc);
        return;
    }
#endif
    put_behind(view, surface, coc);
}

// Composites the surfaces of the pixel near to far.
View composite_surfaces(ivec2 at) {
    View view = EMPTY;
    vec4 surface = vec4(0.0);  // the sum of surfaces at about one depth: rgb times share, a share
    float first_coc = 0.0, dioptres = 0.0;  // of the first of these
    float end_coc = ALL_PX;  // surfaces of this coc or more are left out
#ifdef ALL_DEPTHS
    if (is_hole(at)) end_coc = front_px;
#endif
    for (int k = 0; k < count && surfaces[k].x < end_coc; ++k) {
        float own_dioptres = dioptres_of(surfaces[k].x);
        float tolerance = surface.a > COVERING ? SAME_IF_WHOLE : SAME_SURFACE;
        if (surface.a > 0.0 && own_dioptres * tolerance < dioptres) {
            put_on_its_side(view, surface, first_coc);
            surface = vec4(0.0);
        }
        if (surface.a == 0.0) { first_coc = surfaces[k].x; dioptres = own_dioptres; }
        surface += surfaces[k].y * vec4(surface_number(numbers[k]).color, 1.0);
    }
    if (surface.a > 0.0) put_on_its_side(view, surface, first_coc);
    return view;
}

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy) + ivec2(0, first_row);
    if (any(greaterThanEqual(at, textureSize(coc_tx, 0))) || !is_active(at)) return;
    count = 0;
    for (int k = 0; k < 4; ++k) {
        ivec2 corner = ivec2(k & 1, k >> 1);
        keep_cell(at + corner, equal(corner, ivec2(0)));
    }
    View view = composite_surfaces(at);
    bool is_known = view.light.a > LEAST_KNOWN;
    imageStore(out_view_img, at, is_known ? vec4(view.light.rgb / view.light.a, 1.0) : vec4(0.0));
    float part_scale = lens_part_at(at, textureSize(coc_tx, 0)).z;
    float coc = is_known ? view.coc : max(first_coc_at(at), 0.0);
    imageStore(out_coc_img, at, vec4(part_scale * abs(coc)));
#ifdef ALL_DEPTHS
    imageStore(out_front_img, at, front.light);
    imageStore(out_front_state_img, at, vec4(part_scale * abs(front.coc), front.light.a, 0.0, 0.0));
#endif
}

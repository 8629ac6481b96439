// Draws the view of one part of the lens behind the focus: the surfaces that have moved to each pixel,
// composited near to far. Those at about the same depth add up to one surface.
//
// Inputs
//   lib/far_fragments.lib.glsl
//   head_buf, link_buf   see far_links
//   lib/lens_part.lib.glsl
//   lib/tile_mask.lib.glsl   the tiles in which the view is needed
// Outputs
//   out_view_img   rgb, a 1; all 0 where nothing is known
//   out_coc_img    diameter of the part's own disc, pixels; where nothing is known, as if nothing had moved

#include "lib/far_fragments.lib.glsl"
#include "lib/lens_part.lib.glsl"
#include "lib/tile_mask.lib.glsl"

layout(local_size_x = PIXEL_GROUP, local_size_y = PIXEL_GROUP) in;

uniform int first_row;  // first row of the band (render/defocus/pixel_list.py)
layout(std430) readonly buffer head_block { uint head_buf[]; };
layout(std430) readonly buffer link_block { uvec2 link_buf[]; };
layout(rgba32f) uniform writeonly image2D out_view_img;
layout(r32f) uniform writeonly image2D out_coc_img;

#define HELD_MOST 24         // surfaces kept for a pixel; of more, the nearest
#define SAME_IF_WHOLE 1.003  // the same, once the surface covers the pixel
#define GAIN 1.1             // shares of a stretched surface sum to a little less than 1
#define LEAST_SHARE 1e-4
#define LEAST_KNOWN 0.02

uint numbers[HELD_MOST];
vec2 held[HELD_MOST];  // coc and share of the pixel
int count;

// Keeps the surfaces near to far; of equal ones the order is that of their numbers, so that the sum does
// not depend on the order in which they were linked.
void hold(uint number, float coc, float share) {
    int place = min(count, HELD_MOST - 1);
    bool is_later = count < HELD_MOST || coc < held[place].x || coc == held[place].x && number < numbers[place];
    if (!is_later) return;
    count = min(count + 1, HELD_MOST);
    for (; place > 0; --place) {
        vec2 other = held[place - 1];
        if (other.x < coc || other.x == coc && numbers[place - 1] < number) break;
        held[place] = other;
        numbers[place] = numbers[place - 1];
    }
    held[place] = vec2(coc, share);
    numbers[place] = number;
}

void hold_cell(ivec2 cell, bvec2 is_before) {
    ivec2 cells = textureSize(coc_tx, 0) + 1;
    for (uint link = head_buf[cell.y * cells.x + cell.x]; link != 0u; link = link_buf[link - 1u].x) {
        vec2 beside = unpackUnorm2x16(link_buf[link - 1u].y);
        vec2 near = mix(1.0 - beside, beside, vec2(is_before));
        Fragment fragment = numbered(link - 1u);
        float share = near.x * near.y * fragment.cover;
        if (share > LEAST_SHARE) hold(link - 1u, fragment.coc, share);
    }
}

struct View {
    vec4 seen;    // rgb and the known share
    float coc;    // coc of the most visible surface
    float most;
};

void put_behind(inout View view, vec4 surface, float coc) {
    float cover = min(surface.a * GAIN, 1.0) * (1.0 - view.seen.a);
    view.seen += cover * vec4(surface.rgb / max(surface.a, LEAST_SHARE), 1.0);
    if (cover > view.most) view.coc = coc;
    view.most = max(view.most, cover);
}

View seen_from_part() {
    View view = View(vec4(0.0), 0.0, 0.0);
    vec4 surface = vec4(0.0);
    float first = 0.0, dioptres = 0.0;
    for (int k = 0; k < count; ++k) {
        float own = dioptres_of(held[k].x);
        float same = surface.a > WHOLE ? SAME_IF_WHOLE : SAME_SURFACE;
        if (surface.a > 0.0 && own * same < dioptres) {
            put_behind(view, surface, first);
            surface = vec4(0.0);
        }
        if (surface.a == 0.0) { first = held[k].x; dioptres = own; }
        surface += held[k].y * vec4(numbered(numbers[k]).color, 1.0);
    }
    if (surface.a > 0.0) put_behind(view, surface, first);
    return view;
}

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy) + ivec2(0, first_row);
    if (any(greaterThanEqual(at, textureSize(coc_tx, 0))) || !is_active(at)) return;
    count = 0;
    for (int k = 0; k < 4; ++k) {
        ivec2 past = ivec2(k & 1, k >> 1);
        hold_cell(at + past, equal(past, ivec2(0)));
    }
    View view = seen_from_part();
    bool is_known = view.seen.a > LEAST_KNOWN;
    imageStore(out_view_img, at, is_known ? vec4(view.seen.rgb / view.seen.a, 1.0) : vec4(0.0));
    float part_scale = lens_part_at(at, textureSize(coc_tx, 0)).z;
    imageStore(out_coc_img, at, vec4(part_scale * (is_known ? view.coc : max(far_coc_at(at), 0.0))));
}

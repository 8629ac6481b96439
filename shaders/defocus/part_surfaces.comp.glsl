// Writes the surfaces that the views through the parts of the lens show. The views of all parts read these, which is faster
// than to read the fragment lists for each part. A surface just behind one that covers the same pixel is hidden from
// every part, and is left out: together they would look like one surface of their mean color.
//
// With ALL_DEPTHS, pixels of silhouettes, in which two surfaces are mixed, are taken apart: their mixed colors would stay
// as specks where a near edge was.
//
// Inputs
//   color_tx   rgb of the picture
//   lib/surface_numbers.lib.glsl   the surfaces: fragments of lists, and pixels of the picture, with one numbering
//   lib/tile_numbers.lib.glsl    the tiles whose surfaces are written
//   With ALL_DEPTHS:
//   kind_tx    the kind of each pixel (lib/kind.lib.glsl)
//   far_tx     far edge: rgb of the visible surface, which is the farther one, and coverage of the nearer one; near edge:
//              rgb of the visible surface and its coverage
//   near_tx    far edge: rgb of the nearer surface and its coc
// Outputs
//   lib/part_link.lib.glsl   the surfaces, without their links
//   limit_buf  for each pixel, x the coc that it has in a view that shows nothing there, y the coc from which views leave
//              surfaces out there

#include "lib/surface_numbers.lib.glsl"  // front_index, mixed_index, first_coc_at, Fragment, List, list_at, fragment_of ...
#include "lib/surface_depth.lib.glsl"  // dioptres_of, SAME_SURFACE, COVERING, ALL_PX
#include "lib/part_link.lib.glsl"  // write_surface, hide_surface
#include "lib/tile_numbers.lib.glsl"  // listed_pixel
#include "lib/kind.lib.glsl"  // FAR_EDGE, NEAR_EDGE

layout(local_size_x = TILE, local_size_y = TILE) in;

layout(std430) writeonly buffer limit_block { vec2 limit_buf[]; };
uniform sampler2D color_tx;
#ifdef ALL_DEPTHS
uniform sampler2D kind_tx;
uniform sampler2D far_tx;
uniform sampler2D near_tx;
uniform float front_px;  // a surface with a smaller coc is in front of the focus
#endif

#define BEFORE_ALL 1e30  // dioptres nearer than every surface

// Writes the surfaces that the pixel itself shows, and returns the coc of the visible one.
float write_pixel(ivec2 at) {
    Fragment visible = Fragment(texelFetch(color_tx, at, 0).rgb, 1.0, texelFetch(coc_tx, at, 0).r);
#ifdef ALL_DEPTHS
    float kind = texelFetch(kind_tx, at, 0).r;
    hide_surface(mixed_index(at) + 1u);
    if (kind == FAR_EDGE || kind == NEAR_EDGE) {
        vec4 own = texelFetch(far_tx, at, 0), near = texelFetch(near_tx, at, 0);
        visible.color = own.rgb;
        if (kind == NEAR_EDGE) visible.cover = own.a;
        else if (own.a > 0.0) write_surface(mixed_index(at) + 1u, Fragment(near.rgb, own.a, near.a));
    }
#endif
    write_surface(front_index(at) + 1u, visible);
    return visible.coc;
}

// The coc from which views leave surfaces out at a pixel. If all its known surfaces are in front of the focus, nothing
// is known of what they hide: what is far behind moves there from pixels beside it, although a nearer surface, which is
// not known here, would hide it.
float end_coc_at(ivec2 at) {
#ifdef ALL_DEPTHS
    List list = list_at(at);
    float last_coc = list.first < list.end ? fragment_of(list.end - 1u).coc : texelFetch(coc_tx, at, 0).r;
    return last_coc < front_px ? front_px : ALL_PX;
#else
    return ALL_PX;
#endif
}

void main() {
    ivec2 at = listed_pixel();
    ivec2 size = textureSize(coc_tx, 0);
    if (any(greaterThanEqual(at, size))) return;
    limit_buf[at.y * size.x + at.x] = vec2(max(first_coc_at(at), 0.0), end_coc_at(at));
    List list = list_at(at);  // near to far
    // Dioptres of the last surface that covers the pixel. If the visible surface is not in the list, it is the pixel itself.
    float cover_dioptres = list.has_front ? BEFORE_ALL : dioptres_of(write_pixel(at));
    for (uint i = list.first; i < list.end; ++i) {
        Fragment fragment = fragment_of(i);
        float own_dioptres = dioptres_of(fragment.coc);
        if (own_dioptres * SAME_SURFACE >= cover_dioptres) {
            hide_surface(i + 1u);
            continue;
        }
        write_surface(i + 1u, fragment);
        if (fragment.cover > COVERING) cover_dioptres = own_dioptres;
    }
}

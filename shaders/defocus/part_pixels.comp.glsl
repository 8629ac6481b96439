// Writes the surfaces of each pixel for the views through the parts of the lens opening (render/defocus/part_views.py):
// pixels of silhouettes, in which two surfaces are mixed, are taken apart. All parts read these, which is faster than to
// take pixels apart for each.
//
// Inputs
//   color_tx   rgb of the picture
//   coc_tx     signed coc of the visible surface, pixels
//   kind_tx    the kind of each pixel (lib/kind.lib.glsl)
//   far_tx     far edge: rgb of the visible surface, which is the farther one, and coverage of the nearer one; near edge:
//              rgb of the visible surface and its coverage
//   near_tx    far edge: rgb of the nearer surface and its coc
// Output
//   lib/pixel_surface.lib.glsl

#include "lib/pixel_surface.lib.glsl"  // write_pixel_surface, Fragment
#include "lib/kind.lib.glsl"  // FAR_EDGE, NEAR_EDGE

layout(local_size_x = PIXEL_GROUP, local_size_y = PIXEL_GROUP) in;

uniform int first_row;  // first row of the band (render/defocus/pixel_list.py)
uniform sampler2D color_tx;
uniform sampler2D coc_tx;
uniform sampler2D kind_tx;
uniform sampler2D far_tx;
uniform sampler2D near_tx;

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy) + ivec2(0, first_row), size = textureSize(coc_tx, 0);
    if (any(greaterThanEqual(at, size))) return;
    Fragment visible = Fragment(texelFetch(color_tx, at, 0).rgb, 1.0, texelFetch(coc_tx, at, 0).r);
    Fragment mixed = Fragment(vec3(0.0), 0.0, 0.0);
    float kind = texelFetch(kind_tx, at, 0).r;
    if (kind == FAR_EDGE || kind == NEAR_EDGE) {
        vec4 own = texelFetch(far_tx, at, 0), near = texelFetch(near_tx, at, 0);
        visible.color = own.rgb;
        if (kind == NEAR_EDGE) visible.cover = own.a;
        else mixed = Fragment(near.rgb, own.a, near.a);
    }
    uint pixel = uint(at.y * size.x + at.x);
    write_pixel_surface(pixel, visible);
    write_pixel_surface(pixel + uint(size.x * size.y), mixed);
}

// Computes a level of the pyramid of the surfaces farther than a cut (render/defocus/far_guess.py): each texel is the
// mean of the known ones among 2 x 2 texels of the finer level. A texel has the color and coc of a surface; it is
// known if it shows one that is farther than the cut, and 0 otherwise.
//
// Inputs
//   with FIRST, for level 1: color_tx rgb and coc_tx r, the picture and its signed coc (circle of confusion, diameter
//   in pixels, negative in front of the focus), and cut_px, the coc of the cut
//   else: levels_tx, the pyramid (lib/guess_levels.lib.glsl), which has the finer level at `finer_rect`
// Output
//   out_levels_img     the pyramid; rgb color and a coc are written at `out_rect`, or 0 if no texel is known

layout(local_size_x = PIXEL_GROUP, local_size_y = PIXEL_GROUP) in;

uniform ivec4 out_rect;  // corner and size of the level
layout(rgba32f) uniform writeonly image2D out_levels_img;

#ifdef FIRST
uniform sampler2D color_tx;
uniform sampler2D coc_tx;
uniform float cut_px;  // surfaces with a larger coc are farther than the cut

ivec2 finer_size() { return textureSize(coc_tx, 0); }

bool is_known(vec4 surface) { return surface.a > 0.0; }

// The finer level is the picture itself; only what is farther than the cut is known.
vec4 finer_at(ivec2 at) {
    float coc = texelFetch(coc_tx, at, 0).r;
    return coc > cut_px ? vec4(texelFetch(color_tx, at, 0).rgb, coc) : vec4(0.0);
}
#else
#include "lib/guess_levels.lib.glsl"  // levels_tx

uniform ivec4 finer_rect;  // corner and size of the finer level

ivec2 finer_size() { return finer_rect.zw; }
vec4 finer_at(ivec2 at) { return texelFetch(levels_tx, finer_rect.xy + at, 0); }
#endif

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(at, out_rect.zw))) return;
    vec4 sum = vec4(0.0);
    float known = 0.0;  // number of known texels
    for (int k = 0; k < 4; ++k) {
        ivec2 finer_texel = 2 * at + ivec2(k & 1, k >> 1);
        if (any(greaterThanEqual(finer_texel, finer_size()))) continue;
        vec4 surface = finer_at(finer_texel);
        sum += surface;
        known += float(is_known(surface));
    }
    imageStore(out_levels_img, out_rect.xy + at, sum / max(known, 1.0));
}

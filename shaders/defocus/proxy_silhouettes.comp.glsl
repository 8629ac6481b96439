// Builds the fragment lists of a smaller picture from a plate without lists. A footprint is the area of the whole
// picture that a smaller pixel covers; if it contains a near and a far surface, the pixel lists both, each with its
// color, coverage and distance. Otherwise a thing narrower than the pixel would be mixed with the surface behind it,
// and both would be blurred alike.
//
// Built twice: with COUNT, the pass writes the length of each list; without, after peel_starts.comp.glsl, the lists.
//
// Inputs
//   color_tx, depth_tx   rgba premultiplied, and r meters, of the whole picture
//   positions_tx         of the smaller picture, not 0 at a highlight (proxy.comp.glsl), which counts as one surface
//   proxy_start_buf      without COUNT: the starts of the lists
// Output with COUNT
//   proxy_start_buf      twice the length of each list, 2 or 0, plus 1 if there is one, because it begins with the
//                        visible surface
// Outputs without COUNT
//   proxy_fragment_buf   the fragments, packed as in fragment_buf (lib/fragment_list.lib.glsl)
//   depth_img            r meters of the near surface, where there is a list, of the smaller picture

#include "lib/footprint.lib.glsl"  // Footprint, footprint_of, share_in
#include "lib/fragment_words.lib.glsl"  // WORDS, fragment_words

layout(local_size_x = PIXEL_GROUP, local_size_y = PIXEL_GROUP) in;

uniform sampler2D color_tx;
uniform sampler2D depth_tx;
uniform sampler2D positions_tx;
uniform ivec2 size;                    // size of the smaller picture
layout(r32f) uniform image2D depth_img;

#ifdef COUNT
layout(std430) writeonly buffer proxy_start_block { uint proxy_start_buf[]; };
#else
layout(std430) readonly buffer proxy_start_block { uint proxy_start_buf[]; };
layout(std430) writeonly buffer proxy_fragment_block { uint proxy_fragment_buf[]; };
#endif

#define APART 1.3          // ratio of distances from which a footprint holds two surfaces
#define LEAST_COVER 1e-4   // less coverage than this counts as none

struct Surface {
    vec4 color;      // rgba premultiplied, times the share
    float dioptres;  // times the share
    float share;     // of the footprint
};

Footprint footprint;

float dioptres_at(ivec2 pixel) { return 1.0 / texelFetch(depth_tx, pixel, 0).r; }

// Dioptres between the near and the far surface of the footprint (their geometric mean); 0 if it holds only one.
float border() {
    float least = 1e30, most = 0.0;
    for (int y = footprint.first.y; y <= footprint.last.y; ++y)
        for (int x = footprint.first.x; x <= footprint.last.x; ++x) {
            float dioptres = dioptres_at(ivec2(x, y));
            least = min(least, dioptres);
            most = max(most, dioptres);
        }
    if (most <= APART * least) return 0.0;
    return sqrt(max(least, 1e-3 * most) * most);  // the sky is infinitely far
}

#ifndef COUNT
// The mean of all pixels of the footprint nearer than the border, or of those farther away.
Surface surface(float border, bool is_near) {
    Surface sum = Surface(vec4(0.0), 0.0, 0.0);
    for (int y = footprint.first.y; y <= footprint.last.y; ++y)
        for (int x = footprint.first.x; x <= footprint.last.x; ++x) {
            ivec2 pixel = ivec2(x, y);
            float dioptres = dioptres_at(pixel), pixel_share = share_in(footprint, pixel);
            if (dioptres > border != is_near) continue;
            sum.color += pixel_share * texelFetch(color_tx, pixel, 0);
            sum.dioptres += pixel_share * dioptres;
            sum.share += pixel_share;
        }
    return sum;
}

// Writes a surface as a fragment. `open` is the share of the pixel that nearer surfaces leave uncovered.
void write_fragment(uint number, Surface surface, float open) {
    vec3 color = surface.color.rgb / max(surface.color.a, LEAST_COVER);
    float cover = clamp(surface.color.a / open, 0.0, 1.0);
    uvec3 words = fragment_words(color, cover, surface.dioptres / surface.share);
    for (uint i = 0u; i < WORDS; ++i) proxy_fragment_buf[WORDS * number + i] = words[i];
}
#endif

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(at, size))) return;
    uint index = uint(at.y * size.x + at.x);
    footprint = footprint_of(at, size, textureSize(depth_tx, 0));
#ifdef COUNT
    bool is_highlight = any(notEqual(texelFetch(positions_tx, at, 0), vec4(0.0)));
    // 5: twice the length 2, plus 1.
    proxy_start_buf[index] = !is_highlight && border() > 0.0 ? 5u : 0u;
#else
    uint start = proxy_start_buf[index] >> 1;
    if ((proxy_start_buf[index + 1u] >> 1) - start < 2u) return;
    float border = border();
    Surface near = surface(border, true), far = surface(border, false);
    write_fragment(start, near, 1.0);
    write_fragment(start + 1u, far, max(1.0 - near.color.a, LEAST_COVER));
    imageStore(depth_img, at, vec4(near.share / near.dioptres));
#endif
}

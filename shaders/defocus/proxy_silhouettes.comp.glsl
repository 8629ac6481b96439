// Builds the fragment lists of a smaller picture from a plate without lists: a pixel whose footprint contains a
// near and a far surface lists both, each with its colour, coverage and distance. Otherwise a thing
// narrower than the pixel would be mixed with the surface behind it, and both would be blurred alike.
// Compiled twice: COUNT writes the length of each list; the other, after peel_starts, the lists themselves.
//
// Inputs
//   color_tx, depth_tx   of the whole picture: premultiplied, and metres
//   places_tx            of the smaller one, not 0 at a highlight (proxy.comp.glsl), which is one surface
// Output of COUNT
//   proxy_start_buf      twice the length of each list, plus 1, because it begins with the visible surface
// Input of the other     proxy_start_buf    Outputs
//   proxy_fragment_buf   as fragment_buf (lib/fragment_list.lib.glsl)
//   depth_img            of the smaller picture, metres: of the near surface where there is a list

#include "lib/footprint.lib.glsl"
#include "lib/fragment_words.lib.glsl"

layout(local_size_x = PIXEL_GROUP, local_size_y = PIXEL_GROUP) in;

uniform sampler2D color_tx;
uniform sampler2D depth_tx;
uniform sampler2D places_tx;
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
    vec4 color;      // premultiplied, times its share of the footprint
    float dioptres;  // times its share
    float share;
};

Footprint footprint;

float dioptres_at(ivec2 pixel) { return 1.0 / texelFetch(depth_tx, pixel, 0).r; }

// Dioptres halfway between the two surfaces, as a ratio; 0 if the footprint holds only one.
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
    bool is_highlight = any(notEqual(texelFetch(places_tx, at, 0), vec4(0.0)));
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

// Removes from each near rim pixel the light that shines through it from behind.
//
// Inputs
//   color_tx, coc_tx, kind_tx, two lists    as fragments_find.comp.glsl leaves them
//   with LISTS: fragment lists, which may know what shines through
// Read on the far rim, and on the near rim as fragments_own.comp.glsl leaves it; written on the near rim
//   far_img       far rim: rgb far fragment; near rim: rgb own colour, a its coverage
//   near_img      near rim: a signed coc of the light that shines through

#include "lib/two_lists.lib.glsl"
#include "lib/rim.lib.glsl"
#include "lib/tone.lib.glsl"
#ifdef LISTS
#include "lib/known_behind.lib.glsl"
#endif

layout(local_size_x = PIXELS_PER_GROUP) in;

layout(rgba16f) uniform image2D far_img;
layout(rgba16f) uniform image2D near_img;

#define LEAST_COVERAGE 0.5  // least coverage: depth is sampled at the pixel's centre and hit the near surface

// Color of a farther neighbor, without the near surface.
vec3 far_color(ivec2 at) {
    return kind_at(at) == FAR_RIM ? imageLoad(far_img, at).rgb : color_at(at);
}

// Writes a pixel as it is, fully covered.
void store_unsplit(ivec2 at, vec3 x, float coc) {
    imageStore(far_img, at, vec4(min(x, HALF_MAX), 1.0));
    imageStore(near_img, at, vec4(vec3(0.0), coc));
}

void split_near(uint word) {
    ivec2 at = pixel_of_word(word);
    set_center(at);
    float coc = coc_at(at);
    vec4 unmixed = imageLoad(far_img, at);
    vec3 x = color_at(at), near = unmixed.rgb + imageLoad(near_img, at).rgb;
    if (unmixed.a != OWN_FOUND) {
        if (abs(coc) <= SPLIT_FROM_PX) store_unsplit(at, x, coc);  // fragments_thin.comp.glsl splits others
        return;
    }
    vec4 far = vec4(0.0);  // mean of the farther neighbours: rgb, a = coc
    vec3 squares = vec3(0.0);
    float count = 0.0;
    for (int k = 0; k < 9; ++k) {
        ivec2 p = neighbour(at, k);
        float other = coc_at(p);
        if (!is_in_front(coc, other)) continue;
        vec3 color = far_color(p);
        far += vec4(color, other);
        squares += color * color;
        count += 1.0;
    }
    far /= count;
    float variance = variance_of(far.rgb, squares / count);
#ifdef LISTS
    Fragment behind;
    if (find_behind(at, coc, behind)) {
        far = vec4(behind.color, behind.coc);
        variance = 0.0;
    }
#endif
    float coverage = coverage_of(x, near, far.rgb, variance, own_outline(at, coc));
    coverage = clamp(coverage, LEAST_COVERAGE, 1.0);
    coverage = 1.0 - unmix_share(coc) * (1.0 - coverage);
    vec3 own = max((x - (1.0 - coverage) * far.rgb) / coverage, 0.0);
    imageStore(far_img, at, vec4(min(own, HALF_MAX), coverage));
    imageStore(near_img, at, vec4(vec3(0.0), far.a));
}

void main() { FOR_EACH_IN_BACK(split_near) }

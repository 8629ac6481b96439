// Unmixes the rims of hair before something bright (lib/thin.lib.glsl).
//
// Inputs
//   color_tx, coc_tx, kind_tx    as fragments_find.comp.glsl leaves them
//   pixel list    the rims that may be those of hair, from fragments_own and fragments_far
// Read and written on the far rim, written on the near rim
//   far_img, near_img    as fragments_far.comp.glsl and fragments_near.comp.glsl write them

#include "lib/pixel_list.lib.glsl"
#include "lib/rim.lib.glsl"
#include "lib/tone.lib.glsl"
#include "lib/thin.lib.glsl"

layout(local_size_x = PIXELS_PER_GROUP) in;

layout(rgba16f) uniform image2D far_img;
layout(rgba16f) uniform image2D near_img;

#define LEAST_SEEN 0.7           // visible share of a far surface behind hair from which it keeps its detail
#define LEAST_THIN_COVERAGE 0.1  // least coverage of hair in a pixel whose depth was sampled on it

void split_thin(ivec2 at) {
    set_center(at);
    vec3 x = color_at(at);
    float coc = coc_at(at), behind = coc;
    bool is_far = kind_at(at) == FAR_RIM;
    for (int k = 0; k < 9 && !is_far; ++k) behind = max(behind, coc_at(neighbour(at, k)));
    Mixture mixed = thin_mixture(at, behind, !is_far || is_beside_thin(at, coc));
    vec4 far, near;
    if (is_far) {
        float visible_share = 1.0 - mixed.coverage;
        if (visible_share > LEAST_SEEN) mixed.far = max(x - mixed.coverage * mixed.near, 0.0) / visible_share;
        far = mix(imageLoad(far_img, at), vec4(min(mixed.far, HALF_MAX), mixed.coverage), mixed.sure);
        near = imageLoad(near_img, at);
        near.rgb = mix(near.rgb, min(mixed.near, HALF_MAX), mixed.sure);
    } else {  // the surface behind is guessed in the far layer; wide surfaces keep their pixels
        float transmitted = 1.0 - max(mixed.coverage, LEAST_THIN_COVERAGE);
        float coverage = 1.0 - mixed.sure * unmix_share(coc) * transmitted;
        vec3 own = max((x - (1.0 - coverage) * mixed.far) / coverage, 0.0);
        far = vec4(min(own, HALF_MAX), coverage);
        near = vec4(vec3(0.0), coverage < 1.0 ? behind : coc);
    }
    imageStore(far_img, at, far);
    imageStore(near_img, at, near);
}

void main() { FOR_EACH_LISTED(split_thin) }

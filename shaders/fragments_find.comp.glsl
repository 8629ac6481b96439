// Finds both sides of each silhouette: anti-aliasing has mixed colours there, and depth is one sample.
//
// Inputs
//   coc_tx        signed circle of confusion, diameter in pixels
// Outputs
//   out_kind_img  WHOLE, FAR_RIM or NEAR_RIM
//   pixel list    both rims, for fragments_far and fragments_near

#ifdef LISTS
#include "lib/fragment_list.lib.glsl"
#endif
#include "lib/pixel_list.lib.glsl"
#include "lib/silhouette.lib.glsl"

layout(local_size_x = PIXEL_GROUP, local_size_y = PIXEL_GROUP) in;

layout(r16f) uniform writeonly image2D out_kind_img;

#ifdef LISTS
uniform bool is_measured;  // the lists tell the coverage of every silhouette
bool is_told(ivec2 at) { return is_measured || list_at(inside(at), textureSize(coc_tx, 0)).has_front; }
#else
bool is_told(ivec2 at) { return false; }
#endif

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(at, textureSize(coc_tx, 0)))) return;
    float coc = coc_at(at);
    bool beside_nearer = false, beside_farther = false;
    bool guessed = !is_told(at);
    for (int k = 0; k < 9 && guessed; ++k) {
        if (is_told(neighbour(at, k))) continue;
        float other = coc_at(neighbour(at, k));
        beside_nearer = beside_nearer || is_in_front(other, coc);
        beside_farther = beside_farther || is_in_front(coc, other);
    }
    float kind = beside_nearer ? FAR_RIM : beside_farther ? NEAR_RIM : WHOLE;
    if (kind != WHOLE) list_append(at);
    imageStore(out_kind_img, at, vec4(kind));
}

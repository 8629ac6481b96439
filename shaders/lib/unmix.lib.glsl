// Functions and constants of the passes unmix_*.comp.glsl, which separate the mixed colors of pixels at
// silhouettes.
//
//   near edge    pixel whose depth was sampled on the nearer surface; light of the farther one is mixed in
//   far edge     pixel whose depth was sampled on the farther surface; light of the nearer one is mixed in
//   unmixed     pixel that is not on an edge, and shows its surface alone
//   own color   color of a near edge pixel without the light of the farther surface
//
// Inputs
//   color_tx    rgb of the picture
//   kind_tx     r kind: UNMIXED, FAR_EDGE, NEAR_EDGE or LISTED

#include "lib/silhouette.lib.glsl"  // neighbor, coc_at, is_in_front, is_same_surface, UNMIXED ...

#define HALF_MAX 65504.0  // colors of surfaces are stored in half floats
// Alpha of a near edge pixel whose own color was found, until unmix_near.comp.glsl replaces it by the coverage.
#define OWN_FOUND 2.0       // beside the pixel
#define OWN_BY_OUTLINE 3.0  // from its outline and the known light behind it; up to 1 more in hair, which may cover less
// Hair is narrower than two pixels, so that no pixel certainly shows it alone. It has these colors where what is behind it
// is much brighter.
#define BRIGHTER_FROM 4.0     // ratio of far to near light from which the pixel is unmixed as hair
#define BRIGHTER_FULL 8.0     // ratio from which the confidence in it is 1
#define LEAST_THIN_COVERAGE 0.1  // least coverage of hair in a pixel whose depth was sampled on it

// Range of |coc| over which near edges are unmixed gradually: of their own coc, or of the larger one of both surfaces for
// things so thin that no pixel certainly shows them alone. In focus the others keep their mixed color and cover in full:
// their texture would be taken for coverage (fence C, known: FLIP .0509, .0537).
#define SPLIT_FROM_PX 2.0
#define SPLIT_FULL_PX 6.0

uniform sampler2D color_tx;
uniform sampler2D kind_tx;

vec3 color_at(ivec2 at) { return texelFetch(color_tx, at, 0).rgb; }
float kind_at(ivec2 at) { return texelFetch(kind_tx, at, 0).r; }
bool is_unmixed(ivec2 at) { return kind_at(at) == UNMIXED || kind_at(at) == LISTED; }

// Finds a near edge pixel's own color: the mean of the unmixed pixels of its surface among its neighbors.
// Returns false if there is no such pixel, as on a wire one or two pixels wide.
bool unmix_near(ivec2 at, out vec3 color) {
    float coc = coc_at(at);
    vec4 sum = vec4(0.0);
    for (int k = 0; k < 9; ++k) {
        ivec2 p = neighbor(at, k);
        if (is_unmixed(p) && is_same_surface(coc, coc_at(p))) sum += vec4(color_at(p), 1.0);
    }
    color = sum.rgb / max(sum.a, 1.0);
    return sum.a > 0.0;
}

// Weight, 0..1, of the unmixed color of a near surface, by its own coc or by the larger one of both surfaces.
float unmix_share(float coc) { return smoothstep(SPLIT_FROM_PX, SPLIT_FULL_PX, abs(coc)); }

// True if a nearer surface begins at neighbor `k`, and ends again one or two pixels further on.
bool ends_in(ivec2 at, int k, float coc) {
    ivec2 direction = ivec2(k % 3, k / 3) - 1;
    bool ends = !is_in_front(coc_at(at + 2 * direction), coc) || !is_in_front(coc_at(at + 3 * direction), coc);
    return ends && is_in_front(coc_at(at + direction), coc);
}

// True if a nearer surface beside the pixel is only one or two pixels wide.
bool ends_beside(ivec2 at, float coc) {
    bool ends = false;
    for (int k = 0; k < 9; ++k) ends = ends || ends_in(at, k, coc);
    return ends;
}

// Shared by the two rim passes.

#include "lib/silhouette.lib.glsl"

#define HALF_MAX 65504.0  // fragments are stored in half

uniform sampler2D color_tx;
uniform sampler2D kind_tx;

vec3 color_at(ivec2 at) { return texelFetch(color_tx, at, 0).rgb; }
float kind_at(ivec2 at) { return texelFetch(kind_tx, at, 0).r; }
bool is_unmixed(ivec2 at) { return kind_at(at) == WHOLE || kind_at(at) == LISTED; }

// A near rim pixel's own colour without the background, taken from its surface one pixel further in.
// False if there is no such pixel, as on a wire one or two pixels wide.
bool unmixed_near(ivec2 at, out vec3 color) {
    float coc = coc_at(at);
    vec4 sum = vec4(0.0);
    for (int k = 0; k < 9; ++k) {
        ivec2 p = neighbour(at, k);
        if (is_unmixed(p) && is_same_surface(coc, coc_at(p))) sum += vec4(color_at(p), 1.0);
    }
    color = sum.rgb / max(sum.a, 1.0);
    return sum.a > 0.0;
}

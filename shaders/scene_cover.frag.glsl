// Depth alone: what hides what. With HOLES, of surfaces some of which have holes.

#ifdef HOLES
#include "lib/scene.lib.glsl"
#include "lib/random.lib.glsl"
#include "lib/coverage.lib.glsl"
#include "lib/tint.lib.glsl"

in Uv uv;
flat in uint material;
#endif

void main() {
#ifdef HOLES
    float threshold = threshold_of(uvec2(gl_FragCoord.xy), material, uint(gl_PrimitiveID));
    if (is_hole(material, uv, tint.a, threshold)) discard;
#endif
}

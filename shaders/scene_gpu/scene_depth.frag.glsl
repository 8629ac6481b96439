// Writes planar depth in metres: the distance along the camera's axis, which is clip space's w.

#ifdef HOLES
#include "lib/scene.lib.glsl"
#include "lib/random.lib.glsl"
#include "lib/coverage.lib.glsl"
#include "lib/tint.lib.glsl"

in Uv uv;
flat in uint material;
#endif

out float depth_m;

void main() {
#ifdef HOLES
    float threshold = threshold_of(material, uint(gl_PrimitiveID));
    if (is_hole(material, uv, tint.a, threshold)) discard;
#endif
    depth_m = 1.0 / gl_FragCoord.w;
}

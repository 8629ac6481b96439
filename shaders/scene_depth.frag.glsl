// Planar depth in metres: the distance along the camera's axis, which is what clip space divides by.

#ifdef HOLES
#include "lib/scene.lib.glsl"
#include "lib/tint.lib.glsl"

in vec2 uv;
flat in uint material;
#endif

out float depth_m;

void main() {
#ifdef HOLES
    if (is_hole(material, uv, tint.a)) discard;
#endif
    depth_m = 1.0 / gl_FragCoord.w;
}

// Depth alone: what hides what. With HOLES, of surfaces some of which have holes.

#ifdef HOLES
#include "lib/scene.lib.glsl"
#include "lib/tint.lib.glsl"

in vec2 uv;
flat in uint material;
#endif

void main() {
#ifdef HOLES
    if (is_hole(material, uv, tint.a)) discard;
#endif
}

// Depth alone: what hides what. With HOLES, of surfaces some of which have holes; with PEEL, only of what
// lies behind the surface of the draw before, backs of closed things left out.
//
// Inputs with PEEL
//   before_tx   that surface: r metres, +inf for the sky, if `before_is_depth`; else a dioptres
//   back_rule   of the instance: BACK_NONE for what is open, so that its back can be seen; else how a back
//               is told: by the normals, or by the order of a triangle's corners, one way or the other

#ifdef HOLES
#include "lib/scene.lib.glsl"
#include "lib/random.lib.glsl"
#include "lib/coverage.lib.glsl"
#include "lib/tint.lib.glsl"

in Uv uv;
flat in uint material;
#endif

#ifdef PEEL
#define BACK_NONE 0u
#define BACK_BY_NORMAL 1u
#define BACK_COUNTERCLOCKWISE 2u

// What lies so close behind a surface, as a part of its distance, is the same one.
#define SAME_SURFACE 0.01

in vec3 position_m;
in vec3 normal;
flat in uint back_rule;

uniform sampler2D before_tx;
uniform bool before_is_depth;
uniform vec3 eye_m;

bool is_back() {
    if (back_rule == BACK_NONE) return false;
    if (back_rule == BACK_BY_NORMAL) return dot(normal, eye_m - position_m) < 0.0;
    return gl_FrontFacing == (back_rule == BACK_COUNTERCLOCKWISE);
}

bool is_behind() {
    vec4 before = texelFetch(before_tx, ivec2(gl_FragCoord.xy), 0);
    float dioptres = before_is_depth ? 1.0 / before.r : before.a;
    return gl_FragCoord.w * (1.0 + SAME_SURFACE) < dioptres;
}
#endif

void main() {
#ifdef HOLES
    float threshold = threshold_of(material, uint(gl_PrimitiveID));
    if (is_hole(material, uv, tint.a, threshold)) discard;
#endif
#ifdef PEEL
    if (!is_behind() || is_back()) discard;
#endif
}

// Writes depth alone, for hidden-surface removal. HOLES allows surfaces with holes. PEEL draws only the surfaces
// behind that of the previous draw, without the back faces of closed meshes.
//
// Inputs with PEEL
//   before_tx   that surface: r metres, +inf for the sky, if `before_is_depth`; else a dioptres
//   back_rule   of the instance: BACK_NONE for an open mesh, whose back can be visible; else how back faces
//               are detected: by the normals, or by one of the two winding orders

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

// A surface closer behind than this share of the distance is the same surface.
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
    vec4 previous = texelFetch(before_tx, ivec2(gl_FragCoord.xy), 0);
    float dioptres = before_is_depth ? 1.0 / previous.r : previous.a;
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

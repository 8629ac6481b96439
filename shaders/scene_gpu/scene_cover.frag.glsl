// Writes the depth of surfaces and nothing else, so that afterwards only the visible ones are shaded
// (scene_surface.frag.glsl). With HOLES some surfaces have holes. With PEEL only surfaces behind those of the previous
// draw are drawn, without the back faces of closed meshes.
//
// Inputs with HOLES, from scene_mesh.vert.glsl
//   uv, material, tint   texture coordinates, number of the material, color and alpha of the vertices
// Inputs with PEEL
//   before_tx   the surface of the previous draw: r meters, +inf for the sky, if `before_is_depth`; else a dioptres
//   position_m, normal   of the surface in the world, meters; not a unit vector (scene_mesh.vert.glsl)
//   eye_m       position of the camera in the world, meters
//   back_rule   of the instance: BACK_NONE for an open mesh, whose back can be visible; otherwise the way to detect
//               back faces: by the normals, or by one of the two winding orders

#ifdef HOLES
#include "lib/scene.lib.glsl"  // Uv, is_hole
#include "lib/random.lib.glsl"  // for lib/coverage.lib.glsl
#include "lib/coverage.lib.glsl"  // threshold_of
#include "lib/tint.lib.glsl"  // tint

in Uv uv;
flat in uint material;
#endif

#ifdef PEEL
#define BACK_NONE 0u
#define BACK_BY_NORMAL 1u
#define BACK_COUNTERCLOCKWISE 2u

// A surface that is behind the previous one by less than this share of the distance is the same surface.
#define SAME_SURFACE 0.01

in vec3 position_m;
in vec3 normal;
flat in uint back_rule;

uniform sampler2D before_tx;
uniform bool before_is_depth;
uniform vec3 eye_m;

// True if this is a back face of a closed mesh.
bool is_back() {
    if (back_rule == BACK_NONE) return false;
    if (back_rule == BACK_BY_NORMAL) return dot(normal, eye_m - position_m) < 0.0;
    return gl_FrontFacing == (back_rule == BACK_COUNTERCLOCKWISE);
}

// True if this is another surface, behind that of the previous draw. gl_FragCoord.w is its dioptres.
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

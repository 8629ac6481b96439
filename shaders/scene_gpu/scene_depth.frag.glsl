// Writes the planar depth of surfaces: the distance along the camera's axis, which is the w of clip space. With HOLES
// some surfaces have holes.
//
// Inputs with HOLES, from scene_mesh.vert.glsl
//   uv, material, tint   texture coordinates, number of the material, color and alpha of the vertices
// Output
//   depth_m   meters

#ifdef HOLES
#include "lib/scene.lib.glsl"  // Uv, is_hole
#include "lib/random.lib.glsl"  // for lib/coverage.lib.glsl
#include "lib/coverage.lib.glsl"  // threshold_of
#include "lib/tint.lib.glsl"  // tint

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

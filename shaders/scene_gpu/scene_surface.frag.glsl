// Shades the surfaces that scene_cover.frag.glsl found visible, once for each pixel. The depth test before the shader
// rejects all other surfaces.
//
// Inputs
//   position_m, normal, tangent   of the surface in the world, meters; the vectors have no unit length
//   uv, material, tint   texture coordinates, number of the material, color and alpha of the vertices
//   eye_m   position of the camera in the world, meters
// Output
//   color   scene-linear rgb; alpha 1, or with PEEL the dioptres (1 / meters) of the surface

layout(early_fragment_tests) in;

#include "lib/scene.lib.glsl"  // Uv, Surface, unit_or, surface_of
#include "lib/shading.lib.glsl"  // shade
#include "lib/tint.lib.glsl"  // tint

in vec3 position_m;
in vec3 normal;
in Uv uv;
flat in uint material;
#ifdef BUMPS
in vec4 tangent;
#else
const vec4 tangent = vec4(0.0);
#endif

uniform vec3 eye_m;

out vec4 color;

void main() {
    vec3 to_eye = unit_or(eye_m - position_m, vec3(0.0, 1.0, 0.0));
    Surface surface = surface_of(material, position_m, normal, tangent, uv, tint.rgb, to_eye);
#ifdef PEEL
    color = vec4(shade(surface, to_eye), gl_FragCoord.w);
#else
    color = vec4(shade(surface, to_eye), 1.0);
#endif
}

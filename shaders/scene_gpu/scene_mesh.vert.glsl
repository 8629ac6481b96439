// Transforms a vertex of an instance's mesh, for all fragment shaders that draw surfaces. The position is `invariant`,
// so that the draws of depth and of color compute the same depth.
//
//   COLORS       the mesh has vertex colors
//   BUMPS        materials have normal maps
//   PLACEMENTS   each map has a transform, and there is a second set of texture coordinates
//   PEEL         hidden surfaces are drawn
//
// Inputs
//   in_...            of the vertex: position, normal, texture coordinates, color and tangent; of the instance: its
//                     matrices and numbers
//   clip_from_world   matrix of the camera
// Outputs
//   position_m   in the world, meters
//   normal       in the world, not unit
//   uv           texture coordinates; zw the second set with PLACEMENTS
//   material     number of the material
//   tint         color and alpha of the vertices, with which those of the material are multiplied
//   tangent      with BUMPS: the direction of u on the surface, in the world
//   back_rule    with PEEL: how to detect back faces, BACK_... of scene_cover.frag.glsl

#include "lib/tangent.lib.glsl"  // in_world

in vec3 in_position;
in float in_u;
in vec3 in_normal;
in float in_v;
in vec4 in_to_world_x, in_to_world_y, in_to_world_z, in_to_world_w;  // columns of the matrix of the instance
in vec4 in_to_object_x, in_to_object_y, in_to_object_z, in_to_object_w;
in uvec4 in_numbers;   // the first one is the material
#ifdef COLORS
in vec4 in_color;
#endif
#ifdef BUMPS
in vec4 in_tangent;
#endif
#ifdef PLACEMENTS
in vec2 in_more_uv;
#endif

uniform mat4 clip_from_world;

invariant gl_Position;
out vec3 position_m;
out vec3 normal;
#ifdef PLACEMENTS
out vec4 uv;
#else
out vec2 uv;
#endif
flat out uint material;
#ifdef COLORS
centroid out vec4 tint;
#endif
#ifdef BUMPS
out vec4 tangent;
#endif
#ifdef PEEL
flat out uint back_rule;  // how back faces are detected, see scene_cover.frag.glsl
#endif

void main() {
    mat4 to_world = mat4(in_to_world_x, in_to_world_y, in_to_world_z, in_to_world_w);
    mat3 to_object = mat3(in_to_object_x.xyz, in_to_object_y.xyz, in_to_object_z.xyz);
    vec4 world = to_world * vec4(in_position, 1.0);
    position_m = world.xyz;
    normal = in_normal * to_object;
#ifdef PLACEMENTS
    uv = vec4(in_u, in_v, in_more_uv);
#else
    uv = vec2(in_u, in_v);
#endif
    material = in_numbers.x;
#ifdef COLORS
    tint = in_color;
#endif
#ifdef BUMPS
    tangent = in_world(in_tangent, mat3(to_world));
#endif
#ifdef PEEL
    back_rule = in_numbers.w;
#endif
    gl_Position = clip_from_world * world;
}

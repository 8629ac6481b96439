// A corner of an instance's mesh. `invariant`: what lies on the depth of the first draw is found
// again by the second one. With COLORS, of meshes some of which have colours at their vertices;
// with BUMPS, of materials some of which have a map of normals; with PLACES, of materials whose maps do not
// all lie alike, for which each corner has two sets of texture coordinates; with PEEL, for
// what lies behind others.

#include "lib/tangent.lib.glsl"

in vec3 in_position;
in float in_u;
in vec3 in_normal;
in float in_v;
in mat4 in_to_world;   // of the instance
in mat4 in_to_object;
in uvec4 in_numbers;   // material first
#ifdef COLORS
in vec4 in_color;
#endif
#ifdef BUMPS
in vec4 in_tangent;
#endif
#ifdef PLACES
in vec2 in_more_uv;
#endif

uniform mat4 clip_from_world;

invariant gl_Position;
out vec3 position_m;
out vec3 normal;
#ifdef PLACES
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
flat out uint back_rule;  // how its back is told, see scene_cover.frag.glsl
#endif

void main() {
    vec4 world = in_to_world * vec4(in_position, 1.0);
    position_m = world.xyz;
    normal = in_normal * mat3(in_to_object);
#ifdef PLACES
    uv = vec4(in_u, in_v, in_more_uv);
#else
    uv = vec2(in_u, in_v);
#endif
    material = in_numbers.x;
#ifdef COLORS
    tint = in_color;
#endif
#ifdef BUMPS
    tangent = in_world(in_tangent, mat3(in_to_world));
#endif
#ifdef PEEL
    back_rule = in_numbers.w;
#endif
    gl_Position = clip_from_world * world;
}

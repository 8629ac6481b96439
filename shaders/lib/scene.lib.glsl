// A scene in storage buffers, as render/scene_gpu/scene_buffers.py writes them (std430), and the look-up of the
// properties of its surfaces.
//
//   instances_block   144 bytes for each instance of a mesh; those of one mesh are consecutive
//   placements_block  with PLACEMENTS, how each of the five maps of each material lies on the surface: two vec4 for
//                     each map. The first one is a matrix by rows. The second one has in xy the offset, in z the set
//                     of texture coordinates, and in w how the map repeats: wrap of u + 4 * wrap of v.
//   materials_tx      five texels for each material, MATERIALS_ACROSS of them side by side
//   maps_tx           all maps, one in a layer
//
// The ray tracer reads more (lib/bvh.lib.glsl). The vertex buffer has two vec4 for each vertex: position and u, normal
// and v. With BUMPS it has a third: the tangent and its sign. The index buffer has three uints for each triangle, which
// number all vertices of the scene. If a mesh has colors at its vertices, they are in a buffer of their own, four half
// floats each. With PLACEMENTS the second set of texture coordinates is in another such buffer, two floats each.
//
// With HOLES some materials have holes, or cover only a share of the background. With MAPS some have maps; without, no
// map is read.

struct Instance {
    mat4 to_world;
    mat4 to_object;  // zeros for an instance without extent
    uvec4 numbers;   // numbers: material, mesh, this instance in the scene
};

struct Material {
    vec4 base_color;       // scene-linear rgb, and alpha
    vec4 emission_cutoff;  // scene-linear radiance, and the alpha below which there is a hole
    vec4 rough_metal;      // roughness, metallic, steepness of bumps, strength of occlusion
    ivec4 maps;            // layers of maps_tx: base color, metallic and roughness, emission, normals; -1 for none
    ivec4 more_maps;       // x layer of occlusion, -1 for none; y flags, see below
};

#define UNLIT 1    // unlit: its base color is shown as it is
#define BLENDED 2  // alpha is coverage

layout(std430) readonly buffer instances_block { Instance instances[]; };

#ifdef PLACEMENTS
layout(std430) readonly buffer placements_block { vec4 placements[]; };
#define Uv vec4  // two sets of texture coordinates, xy and zw
#else
#define Uv vec2
#endif

// The maps of a material, in this order.
#define BASE_COLOR 0
#define ROUGH_METAL 1
#define EMISSION 2
#define NORMALS 3
#define OCCLUSION 4

uniform sampler2DArray maps_tx;
uniform sampler2D materials_tx;

Material material_at(uint material) {
    ivec2 at = ivec2(5u * (material % uint(MATERIALS_ACROSS)), material / uint(MATERIALS_ACROSS));
    return Material(
        texelFetch(materials_tx, at, 0), texelFetch(materials_tx, at + ivec2(1, 0), 0),
        texelFetch(materials_tx, at + ivec2(2, 0), 0), ivec4(texelFetch(materials_tx, at + ivec2(3, 0), 0)),
        ivec4(texelFetch(materials_tx, at + ivec2(4, 0), 0))
    );
}

#define SMALL 1e-20
#define LEAST_ALONG 1e-6  // squared sine of the angle below which a tangent is parallel to the normal

// A point to be lit. `normal` and `side` are unit and face the eye; `normal` is that of the normal map, `side` that of
// the mesh.
struct Surface {
    vec3 position_m;
    vec3 normal;
    vec3 side;
    vec3 base_color;
    vec3 emission;
    float metallic;
    float roughness;
    float open;  // unoccluded share of the sky
    bool is_lit;
};

#ifdef PLACEMENTS
#define CLAMP 1
#define MIRROR 2

// A texture coordinate within the map. Beyond its borders the map repeats, unless `wrap` is CLAMP or MIRROR; `texel` is
// the width of a texel.
float wrapped(float at, int wrap, float texel) {
    if (wrap == MIRROR) at = abs(mod(at + 1.0, 2.0) - 1.0);
    return wrap == 0 ? at : clamp(at, 0.5 * texel, 1.0 - 0.5 * texel);
}
#endif

// The texture coordinates at which a map of a material is read.
vec2 map_uv(uint material, int map, Uv uv) {
#ifdef PLACEMENTS
    uint at = 10u * material + 2u * uint(map);
    vec4 matrix = placements[at], offset_set_wraps = placements[at + 1u];
    vec2 surface_uv = offset_set_wraps.z > 0.5 ? uv.zw : uv.xy;
    vec2 own_uv = vec2(dot(matrix.xy, surface_uv), dot(matrix.zw, surface_uv)) + offset_set_wraps.xy;
    int wraps = int(offset_set_wraps.w);
    vec2 texel = 1.0 / vec2(textureSize(maps_tx, 0).xy);
    return vec2(wrapped(own_uv.x, wraps & 3, texel.x), wrapped(own_uv.y, wraps >> 2, texel.y));
#else
    return uv;
#endif
}

// A value of a map; 1 without a map. Bilinear without mipmaps, so that the ray tracer and the rasterizer read the same
// value.
vec4 map_texel(int layer, vec2 uv) {
#ifdef MAPS
    return layer < 0 ? vec4(1.0) : textureLod(maps_tx, vec3(uv, float(layer)), 0.0);
#else
    return vec4(1.0);
#endif
}

vec3 linear_of(vec3 srgb) {  // IEC 61966-2-1
    vec3 curve = pow((srgb + 0.055) / 1.055, vec3(2.4));
    return mix(curve, srgb / 12.92, lessThanEqual(srgb, vec3(0.04045)));
}

// A scene-linear color of a map that is stored in sRGB; white without a map.
vec3 map_color(int layer, vec2 uv) {
#ifdef MAPS
    return layer < 0 ? vec3(1.0) : linear_of(map_texel(layer, uv).rgb);
#else
    return vec3(1.0);
#endif
}

// True if a material has a hole at a point. `opacity` comes from the vertex colors. A partly transparent surface has a
// hole where its coverage is not above `threshold`, which differs from sample to sample.
bool is_hole(uint material, Uv uv, float opacity, float threshold) {
    Material m = material_at(material);
    float cutoff = m.emission_cutoff.a;
    bool is_blended = (m.more_maps.y & BLENDED) != 0;
    if (cutoff <= 0.0 && !is_blended) return false;
    float alpha = m.base_color.a * opacity;
    alpha *= map_texel(m.maps.x, map_uv(material, BASE_COLOR, uv)).a;
    return is_blended ? alpha <= threshold : alpha < cutoff;
}

// The unit vector along v, or `otherwise` if v has no direction.
vec3 unit_or(vec3 v, vec3 otherwise) {
    float square = dot(v, v);
    return square > SMALL && square < 1.0 / SMALL ? v * inversesqrt(square) : otherwise;
}

// The normal with the bumps of the normal map, which is read at `at`. `normal` is unit; `tangent` need be neither unit
// nor perpendicular to it. Returns the normal unchanged if there is no map or the tangent is degenerate.
vec3 with_bumps(Material m, vec3 normal, vec4 tangent, vec2 at) {
#if defined(BUMPS) && defined(MAPS)
    if (m.maps.w < 0) return normal;
    vec3 along = unit_or(tangent.xyz, vec3(0.0));
    along -= normal * dot(normal, along);
    if (dot(along, along) < LEAST_ALONG) return normal;
    along = normalize(along);
    vec3 up = tangent.w < 0.0 ? cross(along, normal) : cross(normal, along);
    vec3 bump = 2.0 * map_texel(m.maps.w, at).xyz - 1.0;
    bump = vec3(m.rough_metal.z * bump.xy, max(bump.z, 0.0));
    return unit_or(bump.x * along + bump.y * up + bump.z * normal, normal);
#else
    return normal;
#endif
}

// The properties of a surface at a point. `normal` and `tangent` may have any length and face either side; `tint` is
// the vertex color; `to_eye` is unit.
Surface surface_of(
    uint material, vec3 position_m, vec3 normal, vec4 tangent, Uv uv, vec3 tint, vec3 to_eye
) {
    Material m = material_at(material);
    vec2 rough_at = map_uv(material, ROUGH_METAL, uv), occlusion_at = map_uv(material, OCCLUSION, uv);
    vec3 rough_metal = m.maps.y < 0 ? vec3(1.0) : map_texel(m.maps.y, rough_at).rgb;
    vec3 unit = unit_or(normal, to_eye);
    Surface s;
    s.position_m = position_m;
    float facing = dot(unit, to_eye) < 0.0 ? -1.0 : 1.0;
    s.side = facing * unit;
    s.normal = facing * with_bumps(m, unit, tangent, map_uv(material, NORMALS, uv));
    s.base_color = tint * m.base_color.rgb * map_color(m.maps.x, map_uv(material, BASE_COLOR, uv));
    s.emission = m.emission_cutoff.rgb * map_color(m.maps.z, map_uv(material, EMISSION, uv));
    s.roughness = clamp(m.rough_metal.x * rough_metal.g, 0.0, 1.0);
    s.metallic = clamp(m.rough_metal.y * rough_metal.b, 0.0, 1.0);
    s.open = 1.0;
    if (m.more_maps.x >= 0) s.open += m.rough_metal.w * (map_texel(m.more_maps.x, occlusion_at).r - 1.0);
    s.is_lit = (m.more_maps.y & UNLIT) == 0;
    return s;
}

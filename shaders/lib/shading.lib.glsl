// The light that leaves a surface, and the sky: the same for the rasteriser and the ray tracer, the
// sun's shadow from one map for both. A comparison of the two is of their lenses, not their light.
// Include lib/scene.lib.glsl first. Uniforms: SceneRaster.shading_uniforms(); textures: maps_tx, shadow_tx.

#include "lib/pi.lib.glsl"

uniform sampler2DShadow shadow_tx;
uniform mat4 shadow_from_world;  // to 0..1 in all three axes
uniform float shadow_texel_m;    // how wide a texel of the map is in the world
uniform vec3 to_sun;             // unit
uniform vec3 sun_light;          // irradiance of what faces it
uniform vec3 sky_zenith;
uniform vec3 sky_horizon;
uniform vec3 sky_ground;
uniform vec3 sky_light[3];       // diffuse light for a normal's y: a + b y + c y^2

#define MOST_LIGHT 65504.0     // the largest half float
#define LEAST_ROUGHNESS 0.1    // a smoother surface's glint would not be found by any number of rays
#define GROUND_BAND 0.1        // the sky goes over into the ground within this, sine of an angle
#define NORMAL_OFFSET 2.0      // texels that a shadow is looked up above the surface

// `direction` is unit; `soft` is by how much its y is spread.
vec3 spread_sky(vec3 direction, float soft) {
    float up = max(direction.y, 0.0);
    vec3 above = mix(sky_horizon, sky_zenith, up * (2.0 - up));
    return mix(sky_ground, above, smoothstep(-GROUND_BAND - soft, soft, direction.y));
}

vec3 sky(vec3 direction) { return spread_sky(direction, 0.0); }

vec3 sky_diffuse(float y) {
    return max(sky_light[0] + y * (sky_light[1] + y * sky_light[2]), 0.0);
}

// Between the sky's mirror image and its diffuse light.
vec3 sky_glossy(vec3 direction, float roughness) {
    vec3 mirrored = spread_sky(direction, roughness);
    return mix(mirrored, sky_diffuse(direction.y), roughness * (2.0 - roughness));
}

// Share of the sun that comes through: four texels compared, from above the surface.
float sun_share(vec3 position_m, vec3 normal) {
    float facing = dot(normal, to_sun), slope = sqrt(max(1.0 - facing * facing, 0.0));
    vec3 from = position_m + normal * (NORMAL_OFFSET * shadow_texel_m * (0.3 + 0.7 * slope));
    vec3 at = (shadow_from_world * vec4(from, 1.0)).xyz;
    if (any(lessThan(at, vec3(0.0))) || any(greaterThan(at, vec3(1.0)))) return 1.0;
    return textureLod(shadow_tx, at, 0.0);
}

// What GGX with the visibility below mirrors more than once, as a factor of what it mirrors once: Turquin 2019.
// The share that a white mirror loses is a fit to its integral, within 4 % of the factor.
vec3 mirrored_again(vec3 facing, float roughness, float nv) {
    const mat4x3 FIT = mat4x3(
        1.898, -6.447, 4.905, -7.705, 32.084, -27.384, 9.531, -42.905, 40.383, -3.816, 18.48, -18.336
    );
    float square = roughness * roughness;
    vec4 powers = vec4(roughness, square, square * roughness, square * square);
    float lost = clamp(dot(vec3(1.0, sqrt(nv), nv), FIT * powers), 0.0, 0.7);
    return 1.0 + facing * lost / (1.0 - lost);
}

// Lambert and GGX with the height-correlated visibility of Heitz 2014, times the cosine. `share` of all light
// is mirrored towards the eye, the rest of it is left to be scattered.
vec3 reflected(Surface s, vec3 to_eye, vec3 to_light, vec3 share) {
    float nl = dot(s.normal, to_light);
    if (nl <= 0.0) return vec3(0.0);
    float nv = max(dot(s.normal, to_eye), 1e-3);
    vec3 half_way = unit_or(to_eye + to_light, s.normal);
    float nh = clamp(dot(s.normal, half_way), 0.0, 1.0), vh = clamp(dot(to_eye, half_way), 0.0, 1.0);
    float a = pow(max(s.roughness, LEAST_ROUGHNESS), 2.0), aa = a * a;
    float spread = nh * nh * (aa - 1.0) + 1.0;
    float visible = 0.5 / (nl * sqrt(nv * nv * (1.0 - aa) + aa) + nv * sqrt(nl * nl * (1.0 - aa) + aa));
    vec3 facing = mix(vec3(0.04), s.base_color, s.metallic);
    vec3 fresnel = facing + (1.0 - facing) * pow(1.0 - vh, 5.0);
    vec3 diffuse = (1.0 - share) * (1.0 - s.metallic) * s.base_color / PI;
    vec3 mirrored = fresnel * mirrored_again(facing, s.roughness, nv);
    return nl * (diffuse + mirrored * (aa / (PI * spread * spread) * visible));
}

// The share of the light from all around that is mirrored: Karis 2014, fit to GGX's integral; and what is
// mirrored more than once, Turquin 2019, without which a rough metal would be dark.
vec3 mirrored_share(vec3 facing, float roughness, float nv) {
    vec4 r = roughness * vec4(-1.0, -0.0275, -0.572, 0.022) + vec4(1.0, 0.0425, 1.04, -0.04);
    float fit = min(r.x * r.x, exp2(-9.28 * nv)) * r.x + r.y;
    vec2 scale = vec2(-1.04, 1.04) * fit + r.zw;
    vec3 more = 1.0 + facing * (1.0 / max(scale.x + scale.y, 0.1) - 1.0);
    return clamp((facing * scale.x + scale.y) * more, 0.0, 1.0);
}

vec3 from_sky(Surface s, vec3 to_eye, vec3 share) {
    vec3 diffuse = (1.0 - share) * (1.0 - s.metallic) * s.base_color * sky_diffuse(s.normal.y);
    return s.open * (diffuse + share * sky_glossy(reflect(-to_eye, s.normal), s.roughness));
}

vec3 from_light(Light light, Surface s, vec3 to_eye, vec3 share) {
    vec3 way = light.position_inner.xyz - s.position_m;
    float square = max(dot(way, way), 1e-4);  // a light is no smaller than a centimetre
    vec3 to_light = unit_or(way, s.normal);
    float inner = light.position_inner.w, outer = light.intensity_outer.w;
    float inside = (-dot(to_light, light.axis.xyz) - outer) / max(inner - outer, 1e-4);
    inside = clamp(inside, 0.0, 1.0);
    float faded = light.axis.w > 1.5 ? inside * inside * (3.0 - 2.0 * inside) : pow(inside, 2.0);
    float cone = light.axis.w > 0.0 ? faded : 1.0;
    return cone / square * light.intensity_outer.rgb * reflected(s, to_eye, to_light, share);
}

// Radiance towards the eye; `to_eye` is unit. Never NaN, never more than a half float holds.
vec3 shaded(Surface s, vec3 to_eye) {
    if (!s.is_lit) return clamp(s.base_color, 0.0, MOST_LIGHT);
    float nv = clamp(dot(s.normal, to_eye), 0.0, 1.0);
    vec3 share = mirrored_share(mix(vec3(0.04), s.base_color, s.metallic), s.roughness, nv);
    vec3 light = s.emission + from_sky(s, to_eye, share);
    if (dot(s.normal, to_sun) > 0.0 && max(sun_light.r, max(sun_light.g, sun_light.b)) > 0.0)
        light += sun_light * sun_share(s.position_m, s.side) * reflected(s, to_eye, to_sun, share);
    for (uint i = 0u; i < light_count.x; ++i) light += from_light(lights[i], s, to_eye, share);
    return clamp(mix(light, vec3(0.0), isnan(light)), 0.0, MOST_LIGHT);
}

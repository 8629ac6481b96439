// The light that leaves a surface towards the eye, and the light of the sky. The rasterizer and the ray tracer share
// this code and the sun's shadow map, so that a comparison of their pictures compares only the lenses.
//
// Include lib/scene.lib.glsl first. SceneRaster.shading_uniforms() gives the uniforms. Light is scene-linear rgb.
//
//   nv, nl, nh, vh   cosines between the normal n, the directions to the eye v and to the light l, and the direction h
//                    half-way between v and l
//   facing           reflectance of a surface that is seen along its normal
//   s.normal, s.side   unit normals towards the eye: with the bumps of the normal map, and of the mesh itself
//   s.open           share of the sky that is not occluded
//   share            share of light that is mirrored; the rest is scattered (diffuse)

#include "lib/finite.lib.glsl"  // is_nan
#include "lib/pi.lib.glsl"      // PI

uniform sampler2DShadow shadow_tx;
uniform mat4 shadow_from_world;  // maps world space to 0..1 in all three axes
uniform float shadow_texel_m;    // width of a texel of the map in the world
uniform vec3 to_sun;             // unit direction to the sun
uniform vec3 sun_light;          // irradiance of a surface that faces it
uniform vec3 sky_zenith;
uniform vec3 sky_horizon;
uniform vec3 sky_ground;
uniform vec3 sky_light[3];       // a, b, c of the sky's diffuse light a + b y + c y^2, y of the normal

uniform int light_count;
uniform vec4 light_rows[3 * MOST_LIGHTS];  // see Light

struct Light {
    vec4 position_inner;   // meters, and a spot's inner cosine
    vec4 intensity_outer;  // rgb, candela-like, and a spot's outer cosine
    vec4 axis;             // xyz unit axis of a spot; w is 1, or 2 if it fades smoothly; zeros if it is no spot
};

#define MOST_LIGHT 65504.0     // the largest half float
#define LEAST_ROUGHNESS 0.1    // rays would miss the glint of a smoother surface
#define GROUND_BAND 0.1        // sine of the angle over which sky and ground blend
#define NORMAL_OFFSET 2.0      // height above the surface, in texels, at which the shadow map is read in grazing light
#define FACING_OFFSET 0.3      // share of that height where the surface faces the sun, against rounding
#define SLOPE_OFFSET 0.7       // share that is added in proportion to the slope; the two sum to 1
#define LEAST_VIEW_COSINE 1e-3 // keeps the visibility term finite at grazing angles
#define DIELECTRIC_F0 0.04     // reflectance of a refractive index of 1.5, the default of glTF
#define MOST_LOST 0.7          // bounds the fit of the lost energy, so that 1 / (1 - lost) stays small
#define LEAST_ALBEDO 0.1       // bounds the energy compensation of the sky's reflection in the same way
#define LEAST_LIGHT_DISTANCE_2 1e-4  // m^2: a light is no smaller than a centimetre
#define SMOOTH_SPOT_FROM 1.5   // axis.w of a light is 0 for no spot, 1 for a spot, 2 for a spot that fades smoothly
#define LEAST_CONE_WIDTH 1e-4  // cosine: a spot with equal inner and outer angle has a hard edge

// The sky in a unit direction, blurred as if the direction's y were spread by `soft`.
vec3 blurred_sky(vec3 direction, float soft) {
    float up = max(direction.y, 0.0);
    vec3 above = mix(sky_horizon, sky_zenith, up * (2.0 - up));
    return mix(sky_ground, above, smoothstep(-GROUND_BAND - soft, soft, direction.y));
}

// The sky in a unit direction.
vec3 sky(vec3 direction) { return blurred_sky(direction, 0.0); }

// The sky's diffuse light on a surface whose normal has this y.
vec3 sky_diffuse(float y) {
    return max(sky_light[0] + y * (sky_light[1] + y * sky_light[2]), 0.0);
}

// The sky's light that a surface of this roughness mirrors: a blend of its mirror image and its diffuse light.
vec3 sky_glossy(vec3 direction, float roughness) {
    vec3 mirrored = blurred_sky(direction, roughness);
    return mix(mirrored, sky_diffuse(direction.y), roughness * (2.0 - roughness));
}

// Visible share of the sun at a point, 0..1: four texels of the shadow map, compared with a point above the surface.
float sun_share(vec3 position_m, vec3 normal) {
    float sun_cosine = dot(normal, to_sun), slope = sqrt(max(1.0 - sun_cosine * sun_cosine, 0.0));
    vec3 from = position_m + normal * (NORMAL_OFFSET * shadow_texel_m * (FACING_OFFSET + SLOPE_OFFSET * slope));
    vec3 at = (shadow_from_world * vec4(from, 1.0)).xyz;
    if (any(lessThan(at, vec3(0.0))) || any(greaterThan(at, vec3(1.0)))) return 1.0;
    return textureLod(shadow_tx, at, 0.0);
}

// Factor on the single reflection that makes up for the light of multiple reflections, which the model of
// `reflect_light` (GGX) leaves out: Turquin 2019. FIT approximates the energy that a white mirror loses, to within 4 %
// of the factor: its columns belong to the powers 1 to 4 of roughness, its rows to 1, sqrt(nv) and nv.
vec3 multiple_reflection_gain(vec3 facing, float roughness, float nv) {
    const mat4x3 FIT = mat4x3(
        1.898, -6.447, 4.905, -7.705, 32.084, -27.384, 9.531, -42.905, 40.383, -3.816, 18.48, -18.336
    );
    float square = roughness * roughness;
    vec4 powers = vec4(roughness, square, square * roughness, square * square);
    float lost = clamp(dot(vec3(1.0, sqrt(nv), nv), FIT * powers), 0.0, MOST_LOST);
    return 1.0 + facing * lost / (1.0 - lost);
}

// How a surface reflects light towards the eye, as far as all lights share it.
struct Reflector {
    vec3 scattered;  // scattered share of the light, for each unit of solid angle
    vec3 facing;
    vec3 gain;       // that of multiple reflections
    float nv, aa;    // nv is at least LEAST_VIEW_COSINE; aa is the fourth power of the roughness
    float masking;   // the part of the visibility term that depends only on the eye
};

Reflector reflector_of(Surface s, vec3 to_eye, vec3 facing, vec3 share) {
    float nv = max(dot(s.normal, to_eye), LEAST_VIEW_COSINE);
    float a = pow(max(s.roughness, LEAST_ROUGHNESS), 2.0), aa = a * a;
    vec3 scattered = (1.0 - share) * (1.0 - s.metallic) * s.base_color / PI;
    vec3 gain = multiple_reflection_gain(facing, s.roughness, nv);
    return Reflector(scattered, facing, gain, nv, aa, sqrt(nv * nv * (1.0 - aa) + aa));
}

// Share of light from a direction that a surface reflects to the eye, times the cosine: Lambert for the scattered
// light, and GGX with the height-correlated visibility of Heitz 2014 for the mirrored light.
vec3 reflect_light(Reflector r, vec3 normal, vec3 to_eye, vec3 to_light) {
    float nl = max(dot(normal, to_light), 0.0);
    vec3 half_way = unit_or(to_eye + to_light, normal);
    float nh = clamp(dot(normal, half_way), 0.0, 1.0), dark = 1.0 - clamp(dot(to_eye, half_way), 0.0, 1.0);
    float spread = nh * nh * (r.aa - 1.0) + 1.0, dark_2 = dark * dark;
    vec3 fresnel = r.facing + (1.0 - r.facing) * (dark_2 * dark_2 * dark);  // Schlick 1994
    float visible = nl * r.masking + r.nv * sqrt(nl * nl * (1.0 - r.aa) + r.aa);
    return nl * (r.scattered + fresnel * r.gain * (r.aa / (2.0 * PI * spread * spread * visible)));
}

// Share of light from all around that is mirrored: the fit of Karis 2014 to the integral of GGX, with the energy
// compensation of Turquin 2019, without which rough metals would be too dark.
vec3 mirrored_share(vec3 facing, float roughness, float nv) {
    const vec4 SLOPE = vec4(-1.0, -0.0275, -0.572, 0.022), CONSTANT = vec4(1.0, 0.0425, 1.04, -0.04);
    const float FALLOFF = -9.28, GAIN = 1.04;
    vec4 r = roughness * SLOPE + CONSTANT;
    float fit = min(r.x * r.x, exp2(FALLOFF * nv)) * r.x + r.y;
    vec2 scale = vec2(-GAIN, GAIN) * fit + r.zw;
    vec3 energy_gain = 1.0 + facing * (1.0 / max(scale.x + scale.y, LEAST_ALBEDO) - 1.0);
    return clamp((facing * scale.x + scale.y) * energy_gain, 0.0, 1.0);
}

// Light of the sky that a surface reflects towards the eye.
vec3 from_sky(Surface s, vec3 to_eye, vec3 share) {
    vec3 diffuse = (1.0 - share) * (1.0 - s.metallic) * s.base_color * sky_diffuse(s.normal.y);
    return s.open * (diffuse + share * sky_glossy(reflect(-to_eye, s.normal), s.roughness));
}

// Light of a lamp that a surface reflects towards the eye.
vec3 from_light(Light light, Surface s, vec3 to_eye, Reflector reflector) {
    vec3 to_lamp = light.position_inner.xyz - s.position_m;
    float square = max(dot(to_lamp, to_lamp), LEAST_LIGHT_DISTANCE_2);
    vec3 to_light = unit_or(to_lamp, s.normal);
    float inner = light.position_inner.w, outer = light.intensity_outer.w;
    float inside = (-dot(to_light, light.axis.xyz) - outer) / max(inner - outer, LEAST_CONE_WIDTH);
    inside = clamp(inside, 0.0, 1.0);
    float spot_share = light.axis.w > SMOOTH_SPOT_FROM ? inside * inside * (3.0 - 2.0 * inside) : pow(inside, 2.0);
    float cone = light.axis.w > 0.0 ? spot_share : 1.0;
    return cone / square * light.intensity_outer.rgb * reflect_light(reflector, s.normal, to_eye, to_light);
}

// Radiance towards the eye; `to_eye` is unit. It is never NaN, and never more than a half float holds.
vec3 shade(Surface s, vec3 to_eye) {
    if (!s.is_lit) return clamp(s.base_color, 0.0, MOST_LIGHT);
    float nv = clamp(dot(s.normal, to_eye), 0.0, 1.0);
    vec3 facing = mix(vec3(DIELECTRIC_F0), s.base_color, s.metallic);
    vec3 share = mirrored_share(facing, s.roughness, nv);
    Reflector reflector = reflector_of(s, to_eye, facing, share);
    vec3 light = s.emission + from_sky(s, to_eye, share);
    if (dot(s.normal, to_sun) > 0.0 && max(sun_light.r, max(sun_light.g, sun_light.b)) > 0.0)
        light += sun_light * sun_share(s.position_m, s.side) * reflect_light(reflector, s.normal, to_eye, to_sun);
    for (int i = 0; i < 3 * light_count; i += 3)
        light += from_light(Light(light_rows[i], light_rows[i + 1], light_rows[i + 2]), s, to_eye, reflector);
    return clamp(mix(light, vec3(0.0), is_nan(light)), 0.0, MOST_LIGHT);
}

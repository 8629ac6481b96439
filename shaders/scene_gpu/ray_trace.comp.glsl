// Renders a scene with depth of field by ray tracing: each ray starts at a random point of the lens and passes through
// its pixel's point in the plane of focus (Cook, Porter and Carpenter 1984, without motion blur). Random numbers are
// independent between pixels and rays, so the remaining error is noise of known size. Each run adds one ray a pixel.
//
// Built with SHAPED for an opening that is not an ellipse, or with a focus of its own for each color; also with IMAGED
// if that opening is a picture. The other switches are those of lib/scene.lib.glsl. With HOLES the thresholds of partly
// transparent surfaces are random numbers, which ray_number (lib/bvh.lib.glsl) starts.
//
// Inputs
//   the blocks of lib/scene.lib.glsl and lib/bvh.lib.glsl, and the inputs of lib/shading.lib.glsl
// In and out
//   sum_img    rgb sum of the light of all rays so far, a their number. With SHAPED only alpha is used, and the light
//              is in the layers of lib/sides.lib.glsl.
// Output
//   mean_img   rgb mean of the rays, alpha 1

#include "lib/scene.lib.glsl"  // Uv, Instance, surface_of, instances
#include "lib/shading.lib.glsl"  // MOST_LIGHT, sky, shade
#include "lib/tangent.lib.glsl"  // for lib/bvh.lib.glsl
#include "lib/random.lib.glsl"  // random4
#include "lib/bvh.lib.glsl"  // Hit, position_of, normal_of, tangent_at, uv_at, tint_at, first_hit, ray_number ...
#include "lib/aperture.lib.glsl"  // aperture_point, aperture_axes, image_point, past_blades, pinhole_position
#include "lib/focus_offset.lib.glsl"  // focus_offset_at
#ifdef SHAPED
#define LEAST_WEIGHT 1e-6   // weight of a ray that the barrel stops: it counts only if no other ray does
#include "lib/sides.lib.glsl"  // Sides, no_sides, read_sides, write_sides, add_light, mean_of
#endif

layout(local_size_x = RAY_GROUP, local_size_y = RAY_GROUP) in;

uniform mat4 world_from_camera;
uniform float focal_px;         // focal length, pixels
uniform float focus_dioptres;   // 1 / distance of focus in the middle of the picture; 0 at infinity
uniform vec2 depths_m;          // near and far clipping distances
uniform vec2 lens_middle_m;      // middle of the lens, in the camera's axes
uniform vec2 pixel_middle_px;   // middle of the square, relative to that of the pixel
uniform float pixel_side_px;    // side of the square that a pixel's rays go through
uniform int top_root;           // root of the tree over the instances
uniform int seed;
uniform int rays;               // rays planned for each pixel; after that many no more are added
uniform int band_start;         // first row of the band that is rendered
uniform bool is_first;          // no ray is in the sum yet
#ifdef SHAPED
uniform float axial_dioptres;   // focus of blue minus that of green, and of green minus that of red
#endif
layout(rgba32f) uniform image2D sum_img;
layout(rgba32f) writeonly uniform image2D mean_img;

// The light of the surface at a hit towards the eye.
vec3 light_at(Hit hit, vec3 to_eye) {
    Instance hit_instance = instances[hit.instance];
    uvec4 c = triangles[hit.triangle];
    vec3 position = mat3(position_of(c.x), position_of(c.y), position_of(c.z)) * hit.weights;
    vec3 normal = mat3(normal_of(c.x), normal_of(c.y), normal_of(c.z)) * hit.weights;
    vec3 position_m = (hit_instance.to_world * vec4(position, 1.0)).xyz;
    Uv uv = uv_at(hit.triangle, hit.weights);
    vec3 tint = tint_at(hit.triangle, hit.weights).rgb;
    normal = normal * mat3(hit_instance.to_object);  // by the inverse transpose
    vec4 tangent = tangent_at(hit.triangle, hit.weights, mat3(hit_instance.to_world));
    uint material = hit_instance.numbers.x;
    return shade(surface_of(material, position_m, normal, tangent, uv, tint, to_eye), to_eye);
}

// The light of a ray through a position `px` in a picture of this size and a point of the lens. `focus` is in dioptres;
// `dioptres` becomes the focus minus the dioptres of the hit, which is positive behind the focus. `slope` is the
// sideways movement of the ray for each meter of depth; it leads through the point of `px` in the plane of focus.
vec3 light_through(vec2 px, vec2 size, vec2 lens_m, float focus, out float dioptres) {
    focus += focus_offset_at(px);
    vec2 slope = (px - 0.5 * size) / focal_px * vec2(1.0, -1.0) - lens_m * focus;
    vec3 along = mat3(world_from_camera) * vec3(slope, -1.0);
    vec3 start = (world_from_camera * vec4(lens_m, 0.0, 1.0)).xyz;
    Hit hit = first_hit(top_root, start, along, depths_m.x, depths_m.y);
    dioptres = focus - (hit.instance < 0 ? 0.0 : 1.0 / hit.distance);
    vec3 direction = normalize(along);
    return hit.instance < 0 ? clamp(sky(direction), 0.0, MOST_LIGHT) : light_at(hit, -direction);
}

#ifdef SHAPED
#define TRIES 16            // attempts to find a point of the opening; the last one counts in any case
#define COLOR_WEIGHTS mat3(1.0)  // row k: the mask of color k

// A random point of the opening, between the blades or in the image, in meters.
#ifdef IMAGED
vec2 lens_point(uvec4 counts, vec2 first) { return aperture_axes * image_point(first); }
#else
vec2 lens_point(uvec4 counts, vec2 first) {
    vec2 point = aperture_point(first);
    // A change of the last counter, the seed, gives numbers that no other ray of this picture uses.
    for (uint k = 1u; k < uint(TRIES) && past_blades(point / aperture_axes).x > 0.0; ++k)
        point = aperture_point(random4(counts + uvec4(0u, 0u, 0u, k << 16u)).zw);
    return point;
}
#endif

// Adds one ray for all colors, or one for each color if their focus differs. `counts` are the counters for random
// numbers, `u` the first of these. Returns the mean light of all rays.
vec3 add_ray(ivec2 at, uvec4 counts, vec4 u, vec2 px, vec2 size, inout vec4 sum) {
    vec2 point = lens_point(counts, u.zw), p = point / aperture_axes;
    int colors = axial_dioptres == 0.0 ? 1 : 3;
    Sides sides = no_sides();
    if (!is_first) sides = read_sides(at);
    for (int k = 0; k < colors; ++k) {
        float focus = focus_dioptres + (colors == 1 ? 0.0 : axial_dioptres * float(k - 1));
        float dioptres;
        vec3 light = light_through(px, size, lens_middle_m + point, focus, dioptres);
        vec2 source_position = pinhole_position(px, p, focal_px * dioptres, aperture_axes);
        vec3 color_mask = colors == 1 ? vec3(1.0) : COLOR_WEIGHTS[k];
        add_light(sides, vec4(light, 1.0), p, source_position, dioptres > 0.0, vec4(color_mask, 0.0));
    }
    sum.a += 1.0;
    write_sides(at, sides);
    return mean_of(sides).rgb;
}

// The mean light of the rays of earlier runs.
vec3 mean_before(ivec2 at, vec4 sum) { return mean_of(read_sides(at)).rgb; }
#else
vec3 mean_before(ivec2 at, vec4 sum) { return sum.rgb / sum.a; }

vec3 add_ray(ivec2 at, uvec4 counts, vec4 u, vec2 px, vec2 size, inout vec4 sum) {
    float dioptres;
    vec3 light = light_through(px, size, lens_middle_m + aperture_point(u.zw), focus_dioptres, dioptres);
    sum += vec4(light, 1.0);
    return mean_before(at, sum);
}
#endif

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy) + ivec2(0, band_start), size = imageSize(sum_img);
    if (any(greaterThanEqual(at, size))) return;
    vec4 sum = is_first ? vec4(0.0) : imageLoad(sum_img, at);
    vec3 mean;
    if (sum.a < float(rays)) {
        uvec4 counts = uvec4(at, uint(sum.a), uint(seed));
        vec4 u = random4(counts);
#ifdef HOLES
        ray_number = uvec3(at.x | at.y << 16, uint(sum.a), uint(seed));
#endif
        vec2 px = vec2(at) + 0.5 + pixel_middle_px + pixel_side_px * (u.xy - 0.5);
        mean = add_ray(at, counts, u, px, vec2(size), sum);
        imageStore(sum_img, at, sum);
    } else mean = mean_before(at, sum);
    imageStore(mean_img, at, vec4(mean, 1.0));
}

// Sums of views or rays through a shaped opening, kept separately for points of the scene behind the focus and in
// front of it. With a bright or soft rim the weights of a view differ between these two sides, and a single sum of
// weights would depend on the scene.
//
// Points in front of the focus get their share of the whole light of the opening, regardless of other points. Points
// behind share the rest by their own weights. A uniform picture therefore stays uniform, and a lamp keeps its light.
//
// Include lib/aperture.lib.glsl with SHAPED first, and define LEAST_WEIGHT, the least weight of a view or ray.
//
// In and out
//   sides_img   a layer for each of the sums below, in their order

struct Sides {
    vec4 behind;         // light times weight, behind the focus
    vec4 behind_weight;  // sum of these weights
    vec4 front;          // light times weight, in front of the focus
    vec4 front_weight;   // sum of these weights
    vec4 front_all;      // sum of the weights of all views or rays if everything were in front
};

layout(rgba32f) uniform image2DArray sides_img;

Sides no_sides() { return Sides(vec4(0.0), vec4(0.0), vec4(0.0), vec4(0.0), vec4(0.0)); }

Sides read_sides(ivec2 at) {
    return Sides(imageLoad(sides_img, ivec3(at, 0)), imageLoad(sides_img, ivec3(at, 1)),
                 imageLoad(sides_img, ivec3(at, 2)), imageLoad(sides_img, ivec3(at, 3)),
                 imageLoad(sides_img, ivec3(at, 4)));
}

void write_sides(ivec2 at, Sides sides) {
    imageStore(sides_img, ivec3(at, 0), sides.behind);
    imageStore(sides_img, ivec3(at, 1), sides.behind_weight);
    imageStore(sides_img, ivec3(at, 2), sides.front);
    imageStore(sides_img, ivec3(at, 3), sides.front_weight);
    imageStore(sides_img, ivec3(at, 4), sides.front_all);
}

// Adds light that came through the point `p` of the opening, in radii, to the channels whose mask in `colors` is 1.
// `position` is that of its source in the pinhole picture, pixels.
void add_light(inout Sides sides, vec4 light, vec2 p, vec2 position, bool is_behind, vec4 colors) {
    vec4 in_front = max(aperture_weight(p, position, false), LEAST_WEIGHT) * colors;
    sides.front_all += in_front;
    if (is_behind) {
        vec4 weight = max(aperture_weight(p, position, true), LEAST_WEIGHT) * colors;
        sides.behind += weight * light;
        sides.behind_weight += weight;
    } else {
        sides.front += in_front * light;
        sides.front_weight += in_front;
    }
}

// The mean light of all views or rays.
vec4 mean_of(Sides sides) {
    vec4 all = max(sides.front_all, 1e-30), behind = sides.behind / max(sides.behind_weight, 1e-30);
    return sides.front / all + (1.0 - sides.front_weight / all) * behind;
}

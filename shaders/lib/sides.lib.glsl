// Sums of views or rays through a shaped opening, separately for the two sides of the focus: with a rim their weights
// differ, and a single sum of weights would depend on the scene.
//
// A point in front of the focus gets its share of the whole light of the opening, regardless of other points.
// Points behind share the rest by their own weights. A uniform picture therefore stays uniform, and a lamp
// keeps its light.
//
// `sides_img` holds a layer for each of the sums below.

struct Sides {
    vec4 behind;         // light times weight, behind the focus
    vec4 behind_weight;
    vec4 front;          // light times weight, in front of the focus
    vec4 front_weight;
    vec4 front_all;      // the weight if everything were in front
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

// Adds light that came through a point of the opening to the channels whose mask in `colors` is 1.
void add_light(inout Sides sides, vec4 light, vec2 p, vec2 place, bool is_behind, vec4 colors) {
    vec4 in_front = max(aperture_weight(p, place, false), LEAST_WEIGHT) * colors;
    sides.front_all += in_front;
    if (is_behind) {
        vec4 weight = max(aperture_weight(p, place, true), LEAST_WEIGHT) * colors;
        sides.behind += weight * light;
        sides.behind_weight += weight;
    } else {
        sides.front += in_front * light;
        sides.front_weight += in_front;
    }
}

// The mean of all views or rays.
vec4 mean_of(Sides sides) {
    vec4 all = max(sides.front_all, 1e-30), behind = sides.behind / max(sides.behind_weight, 1e-30);
    return sides.front / all + (1.0 - sides.front_weight / all) * behind;
}

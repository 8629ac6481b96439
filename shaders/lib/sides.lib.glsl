// What views or rays through a shaped opening have seen so far, apart for the two sides of the focus: with a
// rim their weights differ, so that the sum of all weights would depend on what is seen.
//
// A point in front of the focus gets its part of all the light of the opening, whatever else there is. What
// lies behind gets what that leaves, by its own weights. So one brightness everywhere stays that brightness,
// and a lamp keeps its light.
//
// `sides_img` holds a layer for each of the sums below.

struct Sides {
    vec4 behind;         // light times weight of what is behind the focus
    vec4 behind_weight;
    vec4 front;          // the same of what is in front of it
    vec4 front_weight;
    vec4 front_all;      // the weight that it would have if all were in front
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

// Adds light that came through a point of the opening to a place of the picture, for the colours that are 1
// in `colors`.
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

vec4 mean_of(Sides sides) {
    vec4 all = max(sides.front_all, 1e-30), behind = sides.behind / max(sides.behind_weight, 1e-30);
    return sides.front / all + (1.0 - sides.front_weight / all) * behind;
}

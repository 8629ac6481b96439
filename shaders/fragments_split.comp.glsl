// Splits each rim pixel in two: its far colour is taken from the far side alone, the nearer colour
// from its nearer neighbours, and the nearer one's coverage is where the pixel's colour lies between.
//
// Inputs
//   color_tx      scene-linear rgb
//   coc_tx        signed circle of confusion, diameter in pixels
//   rim_tx        1 on the rim
//   pixel list    the rim
// Outputs (rim only)
//   out_far_img   rgb of the far fragment, a coverage of the near one
//   out_near_img  rgb of the near fragment, a its signed coc

#define PIXEL_LIST_BINDING 0
#include "lib/pixel_list.lib.glsl"
#include "lib/silhouette.lib.glsl"
#include "lib/tone.lib.glsl"

layout(local_size_x = PIXELS_PER_GROUP) in;

uniform sampler2D color_tx;
uniform sampler2D rim_tx;
layout(rgba32f) uniform writeonly image2D out_far_img;
layout(rgba32f) uniform writeonly image2D out_near_img;

#define SAME_SURFACE 1.05  // neighbours up to this many times the nearest depth make the near colour
#define RIM_WEIGHT 0.1     // of a near neighbour that is mixed itself
#define FAR_REACH 2        // pixels: across a wire's far rim to the next unmixed pixel

vec3 color_at(ivec2 at) { return texelFetch(color_tx, inside(at), 0).rgb; }
bool is_rim(ivec2 at) { return texelFetch(rim_tx, inside(at), 0).r > 0.5; }

// Mean of the unmixed pixels around on the same surface, compressed; a = their weight.
vec4 far_side(ivec2 at, float coc) {
    vec4 sum = vec4(0.0);
    for (int y = -FAR_REACH; y <= FAR_REACH; ++y)
        for (int x = -FAR_REACH; x <= FAR_REACH; ++x) {
            ivec2 p = at + ivec2(x, y);
            float other = coc_at(p);
            if (is_in_front(other, coc) || is_in_front(coc, other) || is_rim(p)) continue;
            sum += vec4(toned(color_at(p)), 1.0) / float(x * x + y * y);
        }
    return sum;
}

float nearest_around(ivec2 at, float coc) {
    float nearest = coc;
    for (int y = -1; y <= 1; ++y)
        for (int x = -1; x <= 1; ++x) {
            float other = coc_at(at + ivec2(x, y));
            if (is_in_front(other, coc)) nearest = min(nearest, other);
        }
    return nearest;
}

// Mean colour of the neighbours on the nearest surface; a its mean coc.
vec4 near_side(ivec2 at, float coc) {
    float nearest = nearest_around(at, coc);
    vec4 sum = vec4(0.0);
    float weights = 0.0;
    for (int y = -1; y <= 1; ++y)
        for (int x = -1; x <= 1; ++x) {
            ivec2 p = at + ivec2(x, y);
            float other = coc_at(p);
            if (!is_in_front(other, coc)) continue;
            if (inverse_depth(other) * SAME_SURFACE < inverse_depth(nearest)) continue;
            float weight = is_rim(p) ? RIM_WEIGHT : 1.0;
            sum += weight * vec4(color_at(p), other);
            weights += weight;
        }
    return sum / weights;
}

void main() {
    ivec2 at;
    if (!list_pixel(gl_GlobalInvocationID.x, at)) return;
    float coc = coc_at(at);
    vec3 x = color_at(at), far = x;
    vec4 unmixed = far_side(at, coc), near = near_side(at, coc);
    if (unmixed.a > 0.0) far = untoned(unmixed.rgb / unmixed.a);
    vec3 across = near.rgb - far;
    float coverage = clamp(dot(x - far, across) / max(dot(across, across), 1e-5), 0.0, 1.0);
    // What the mix does not explain is texture of the far side, as far as that is seen.
    float seen = 1.0 - coverage;
    vec3 rest = (x - far - coverage * across) / max(seen, 0.2);
    far = max(far + smoothstep(0.3, 0.7, seen) * rest, 0.0);
    imageStore(out_far_img, at, vec4(far, coverage));
    imageStore(out_near_img, at, near);
}

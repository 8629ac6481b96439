// Anti-aliased silhouette pixels hold two colours and one depth. Each far pixel beside a nearer one
// is split: its far colour is taken from the far side alone, the nearer colour from its nearer
// neighbours, and the nearer one's coverage is where the pixel's colour lies between the two.
//
// Inputs
//   color_tx      scene-linear rgb
//   coc_tx        signed circle of confusion, diameter in pixels
// Outputs
//   out_far_img   rgb of the far fragment (the pixel's own colour off the rim), a coverage of the near
//   out_near_img  rgb of the near fragment, a its signed coc

#include "lib/tone.lib.glsl"

layout(local_size_x = 16, local_size_y = 16) in;

uniform sampler2D color_tx;
uniform sampler2D coc_tx;
uniform float at_infinity_px;  // coc of what is infinitely far away: coc - this is proportional to 1/z
layout(rgba32f) uniform writeonly image2D out_far_img;
layout(rgba32f) uniform writeonly image2D out_near_img;

#define JUMP_PX 3.0         // less of a step in coc cannot be told from a slanted surface
#define DEPTH_RATIO 0.95    // and a surface nearer by less than this is the same surface
#define SAME_SURFACE 1.05   // neighbours up to this many times the nearest depth make the near colour
#define RIM_WEIGHT 0.1      // of a near neighbour that is mixed itself
#define FAR_REACH 2         // pixels; beyond the rim, which is one pixel wide on each side of a wire

ivec2 size;

ivec2 inside(ivec2 at) { return clamp(at, ivec2(0), size - 1); }
float coc_at(ivec2 at) { return texelFetch(coc_tx, inside(at), 0).r; }
vec3 color_at(ivec2 at) { return texelFetch(color_tx, inside(at), 0).rgb; }
float inverse_depth(float coc) { return at_infinity_px - coc; }  // up to a factor

bool is_in_front(float coc, float of) {
    return abs(coc - of) > JUMP_PX && inverse_depth(coc) * DEPTH_RATIO > inverse_depth(of);
}

bool is_rim(ivec2 at, float coc) {
    for (int y = -1; y <= 1; ++y)
        for (int x = -1; x <= 1; ++x)
            if (is_in_front(coc_at(at + ivec2(x, y)), coc)) return true;
    return false;
}

// Mean of the unmixed pixels around that are not in front; a = their weight.
vec4 far_side(ivec2 at, float coc) {
    vec4 sum = vec4(0.0);
    for (int y = -FAR_REACH; y <= FAR_REACH; ++y)
        for (int x = -FAR_REACH; x <= FAR_REACH; ++x) {
            ivec2 p = at + ivec2(x, y);
            float other = coc_at(p);
            if (is_in_front(other, coc) || is_in_front(coc, other) || is_rim(p, other)) continue;
            float weight = 1.0 / float(x * x + y * y);
            sum += weight * vec4(toned(color_at(p)), 1.0);
        }
    return sum;
}

// Mean colour and coc of the nearer neighbours on the nearest surface; weight 0: none.
void near_side(ivec2 at, float coc, out vec3 color, out float near_coc, out float weight) {
    float nearest = coc;
    for (int y = -1; y <= 1; ++y)
        for (int x = -1; x <= 1; ++x) {
            float other = coc_at(at + ivec2(x, y));
            if (is_in_front(other, coc)) nearest = min(nearest, other);
        }
    color = vec3(0.0);
    near_coc = weight = 0.0;
    for (int y = -1; y <= 1; ++y)
        for (int x = -1; x <= 1; ++x) {
            ivec2 p = at + ivec2(x, y);
            float other = coc_at(p);
            if (!is_in_front(other, coc)) continue;
            if (inverse_depth(other) * SAME_SURFACE < inverse_depth(nearest)) continue;
            float w = is_rim(p, other) ? RIM_WEIGHT : 1.0;
            color += w * color_at(p);
            near_coc += w * other;
            weight += w;
        }
    color /= max(weight, 1e-6);
    near_coc /= max(weight, 1e-6);
}

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    size = textureSize(coc_tx, 0);
    if (any(greaterThanEqual(at, size))) return;
    float coc = coc_at(at);
    vec3 x = color_at(at), far = x, near = vec3(0.0);
    float near_coc = coc, coverage = 0.0, weight = 0.0;
    if (is_rim(at, coc)) {
        vec4 sum = far_side(at, coc);
        if (sum.a > 0.0) far = untoned(sum.rgb / sum.a);
        near_side(at, coc, near, near_coc, weight);
        vec3 across = near - far;
        coverage = clamp(dot(x - far, across) / max(dot(across, across), 1e-5), 0.0, 1.0);
        // What the mix does not explain is texture of the far side, as far as that is seen.
        float seen = 1.0 - coverage;
        vec3 rest = (x - far - coverage * across) / max(seen, 0.2);
        far = max(far + smoothstep(0.3, 0.7, seen) * rest, 0.0);
    }
    imageStore(out_far_img, at, vec4(far, coverage));
    imageStore(out_near_img, at, vec4(near, near_coc));
}

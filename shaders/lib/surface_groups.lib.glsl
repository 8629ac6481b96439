// Groups the samples of a pixel into surfaces, near to far. The samples are those of the visible surface (front) and of
// the next two surfaces behind it. Samples whose distances differ by a ratio of less than SAME_GROUP are one surface.
// Distances are in dioptres (1 / meters), 0 for the sky. FRONT_SIDE and BEHIND_SIDE are defines, because a processor
// divides by a uniform number by number.
//
// Inputs
//   front_tx    FRONT_SIDE x FRONT_SIDE samples a pixel in each of PEEL_DRAWS draws, which lie below each other:
//               rgb, a dioptres
//   done_tx     1 where only one surface is visible in a pixel, and front_tx has no samples
//   first_tx    BEHIND_SIDE x BEHIND_SIDE samples a pixel: r meters of the visible surface, +inf for the sky
//   behind_tx   the same samples: rgb, a dioptres of the next surface
//   last_tx     the same samples: rgb, a dioptres of the surface after that

#include "lib/finite.lib.glsl"  // is_infinite

uniform sampler2D front_tx;
uniform sampler2D done_tx;
uniform sampler2D first_tx;
uniform sampler2D behind_tx;
uniform sampler2D last_tx;

#define SAME_GROUP 1.03    // ratio of distances within which samples are of one surface
#define LEAST_COVER 0.004  // less than the smallest share that samples can resolve
#define BEHIND_COUNT (BEHIND_SIDE * BEHIND_SIDE)

// State of the pixel that this invocation processes; `begin_pixel` sets it.
bool is_done;
int front_count;     // number of front samples; 1 if the pixel is done
float own_dioptres;  // dioptres of the visible surface, used if the pixel is done
vec4 behind_samples[2 * BEHIND_COUNT];  // those of `behind_sample`, which each surface looks through

// Front sample i of a pixel: rgb, a dioptres. In a pixel that is done it has no color.
vec4 front_sample(ivec2 pixel, int i) {
    if (is_done) return vec4(vec3(0.0), own_dioptres);
    int draw = i % PEEL_DRAWS, number = i / PEEL_DRAWS, height = textureSize(front_tx, 0).y / PEEL_DRAWS;
    ivec2 at = FRONT_SIDE * pixel + ivec2(number % FRONT_SIDE, number / FRONT_SIDE);
    return texelFetch(front_tx, at + ivec2(0, draw * height), 0);
}

// A surface in a pixel.
struct Group {
    vec3 color;
    float cover;     // if visible, its share of what nearer surfaces leave open; else its share of the pixel
    float dioptres;
    bool is_visible;
};

// One sample of the next surface, or with `is_last` of the one after it: rgb, a dioptres. Alpha is -1 where there is
// none, because the sky is in front of it.
vec4 behind_sample(ivec2 at, bool is_last) {
    vec4 next = texelFetch(behind_tx, at, 0);
    bool has_next = !is_infinite(texelFetch(first_tx, at, 0).r);
    if (!is_last) return has_next ? next : vec4(vec3(0.0), -1.0);
    return has_next && next.a > 0.0 ? texelFetch(last_tx, at, 0) : vec4(vec3(0.0), -1.0);
}

// Prepares a pixel: `at` in the picture, `pixel` in the band that was drawn. `depth_m` is that of the picture.
void begin_pixel(ivec2 at, ivec2 pixel, float depth_m) {
    is_done = texelFetch(done_tx, at, 0).r > 0.0;
    front_count = is_done ? 1 : PEEL_DRAWS * FRONT_SIDE * FRONT_SIDE;
    own_dioptres = 1.0 / depth_m;
    for (int i = 0; i < 2 * BEHIND_COUNT; ++i) {
        int k = i >> 1;
        ivec2 sample_at = BEHIND_SIDE * pixel + ivec2(k % BEHIND_SIDE, k / BEHIND_SIDE);
        behind_samples[i] = behind_sample(sample_at, (i & 1) == 1);
    }
}

// Dioptres of the nearest sample of a pixel. A hidden one may be nearer than all visible ones, because these are at
// other points of the pixel.
float nearest_sample(ivec2 pixel) {
    float nearest = -1.0;
    for (int i = 0; i < front_count; ++i) nearest = max(nearest, front_sample(pixel, i).a);
    for (int i = 0; i < 2 * BEHIND_COUNT; ++i) nearest = max(nearest, behind_samples[i].a);
    return nearest;
}

// The surface of the samples from `low` up to, but excluding, `high` dioptres. `open_count` is the number of front
// samples that no surface so far has taken; those of this surface are subtracted. `next` becomes the dioptres of the
// nearest sample below `low`, -1 for none. Finding it here reads each sample only once for each surface.
Group group_within(ivec2 pixel, float low, float high, inout int open_count, out float next) {
    vec4 visible = vec4(0.0), hidden = vec4(0.0);
    int visible_count = 0, hidden_count = 0;
    next = -1.0;
    for (int i = 0; i < front_count; ++i) {
        vec4 x = front_sample(pixel, i);
        bool is_within = x.a >= low && x.a < high;
        visible += is_within ? x : vec4(0.0);
        visible_count += int(is_within);
        if (x.a < low) next = max(next, x.a);
    }
    for (int i = 0; i < 2 * BEHIND_COUNT; ++i) {
        vec4 x = behind_samples[i];
        bool is_within = x.a >= low && x.a < high;
        hidden += is_within ? x : vec4(0.0);
        hidden_count += int(is_within);
        if (x.a < low) next = max(next, x.a);
    }
    if (visible_count > 0) {
        float cover = visible_count == open_count ? 1.0 : float(visible_count) / float(open_count);
        open_count -= visible_count;
        visible /= float(visible_count);
        return Group(visible.rgb, cover, visible.a, true);
    }
    // The surface is hidden: all its samples are behind nearer surfaces.
    float behind = 1.0 - float(open_count) / float(front_count);
    float cover = behind * min(float(hidden_count) / float(BEHIND_COUNT), 1.0);
    hidden /= float(max(hidden_count, 1));
    return Group(hidden.rgb, cover, hidden.a, false);
}

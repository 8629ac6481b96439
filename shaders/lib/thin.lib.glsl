// Unmixes hair narrower than two pixels before something much brighter: no pixel there surely shows one
// surface alone. The near colour is the darkest around; the far colour is that pixel around with which
// the mix is explained best, because a mean would mix a window with its bars.
//
// Part of fragments_thin.comp.glsl, after lib/rim.lib.glsl and lib/tone.lib.glsl.

#define THIN_REACH 3          // pixels
#define THIN_SIDE 7
#define BRIGHTER_FROM 4.0     // times the light of the near colour: from here on the mix tells the coverage,
#define BRIGHTER_FULL 8.0     // and from here on it alone does
#define DISTANCE_PRICE 0.01   // for each pixel between the mix and its far colour,
#define MIXED_PRICE 0.05      // for each nearer pixel in the row and column of the far colour,
#define MISSED_PRICE 0.3      // for coverage where depth, sampled at the pixel's centre, missed the near
#define MISSED_COVERAGE 0.5   // surface, above this

struct Mixture {
    vec3 near, far;
    float coverage;  // of the near colour
    float sure;      // how far this holds, 0..1
};

struct Extremes {
    vec3 darkest;      // of the nearer pixels
    float near_light;  // its light
    float far_light;   // most light of the other pixels
};

ivec2 aside_of(int i) { return ivec2(i % THIN_SIDE, i / THIN_SIDE) - THIN_REACH; }

Extremes extremes_around(ivec2 at, float far_coc, bool is_thin) {
    Extremes found = Extremes(vec3(0.0), HALF_MAX, 0.0);
    int i = is_thin ? 0 : THIN_SIDE * THIN_SIDE - 1;  // of a loop, because llvmpipe runs both sides of a branch
    do {
        ivec2 p = inside(at + aside_of(i));
        vec3 color = color_at(p);
        float light = mean_of(color);
        bool is_nearer = is_in_front(coc_at(p), far_coc);
        if (is_nearer && light < found.near_light) found.darkest = color;
        if (is_nearer) found.near_light = min(found.near_light, light);
        else found.far_light = max(found.far_light, light);
    } while (++i < THIN_SIDE * THIN_SIDE);
    return found;
}

float nearer_beside(ivec2 at, float far_coc) {
    float count = 0.0;
    for (int k = 1; k < 9; k += 2) count += is_in_front(coc_at(neighbour(at, k)), far_coc) ? 1.0 : 0.0;
    return count;
}

// True beside something nearer that ends again after one or two pixels, which nowhere shows alone.
bool is_beside_thin(ivec2 at, float coc) {
    uint ending = 0u;  // looked at last, because that takes longer
    for (int k = 0; k < 9; ++k) ending |= uint(ends_in(at, k, coc)) << k;
    bool is_thin = false;
    while (ending != 0u && !is_thin) {
        vec3 own;
        is_thin = !unmixed_near(neighbour(at, findLSB(ending)), own);
        ending &= ending - 1u;
    }
    return is_thin;
}

// `far_coc` is that of the surface behind the thing. Confidence (`sure`) is 0 where the thing is not thin.
Mixture thin_mixture(ivec2 at, float far_coc, bool is_thin) {
    vec3 x = color_at(at);
    Extremes found = extremes_around(at, far_coc, is_thin);
    float ratio = found.far_light / max(found.near_light, 1e-3);
    Mixture best = Mixture(x, x, 1.0, is_thin ? smoothstep(BRIGHTER_FROM, BRIGHTER_FULL, ratio) : 0.0);
    float least = HALF_MAX, missed = is_in_front(coc_at(at), far_coc) ? 0.0 : MISSED_PRICE;
    int i = best.sure > 0.0 ? 0 : THIN_SIDE * THIN_SIDE - 1;
    do {
        ivec2 aside = aside_of(i), p = inside(at + aside);
        if (is_in_front(coc_at(p), far_coc)) continue;
        vec3 far = color_at(p), across = found.darkest - far;
        float squared = dot(across, across), part = clamp(dot(x - far, across) / max(squared, 1e-5), 0.0, 1.0);
        vec3 rest = x - far - part * across;
        float price = dot(rest, rest) / (squared + 0.01) + missed * max(part - MISSED_COVERAGE, 0.0);
        price += DISTANCE_PRICE * length(vec2(aside)) + MIXED_PRICE * nearer_beside(p, far_coc);
        if (price >= least) continue;
        least = price;
        best = Mixture(found.darkest, far, part, best.sure);
    } while (++i < THIN_SIDE * THIN_SIDE);
    return best;
}

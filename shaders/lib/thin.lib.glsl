// Separates the colors that are mixed in a pixel with hair (near) in front of a much brighter surface (far). Hair is
// narrower than two pixels, so that no pixel certainly shows one surface alone. The near color is the darkest of the
// nearer pixels around. The far color is that of the pixel around that explains the mix best, because a mean would
// mix a window with its bars: each candidate has a price, and the lowest one counts.
//
// With LISTS, what is known to be behind a nearer pixel is a candidate too.
//
// Nearer pixels are those whose depth was sampled on a surface in front of the far one.
//
// Part of unmix_thin.comp.glsl, after lib/bit_search.lib.glsl, lib/unmix.lib.glsl and lib/tone.lib.glsl.

#define THIN_SIDE 7           // side of the searched square, pixels
#define DISTANCE_PRICE 0.01   // added to the price for each pixel of distance to the candidate
#define MIXED_PRICE 0.05      // added for each nearer pixel above, below, left and right of the candidate
#define MISSED_PRICE 0.3      // times the excess coverage, in a pixel whose depth sample missed the near surface
#define MISSED_COVERAGE 0.5   // coverage above which there is such an excess

struct Mixture {
    vec3 near, far;  // rgb of the two surfaces
    float coverage;  // share of the pixel that the near surface covers
    float sure;      // confidence, 0..1
};

struct Extremes {
    vec3 darkest;      // of the nearer pixels
    float near_light;  // mean of its rgb
    float far_light;   // largest mean of rgb of the other pixels
};

// Offset of pixel i of the searched square from its middle.
ivec2 offset_of(int i) { return ivec2(i % THIN_SIDE, i / THIN_SIDE) - THIN_SIDE / 2; }

// The darkest nearer pixel and the brightest other pixel around; of one pixel only, unless `is_thin`.
Extremes extremes_around(ivec2 at, float far_coc, bool is_thin) {
    Extremes extremes = Extremes(vec3(0.0), HALF_MAX, 0.0);
    int i = is_thin ? 0 : THIN_SIDE * THIN_SIDE - 1;  // a loop of one round is cheaper on llvmpipe than a branch
    do {
        ivec2 p = inside(at + offset_of(i));
        vec3 color = color_at(p);
        float light = mean_of(color);
        bool is_nearer = is_in_front(coc_at(p), far_coc);
        if (is_nearer && light < extremes.near_light) extremes.darkest = color;
        if (is_nearer) extremes.near_light = min(extremes.near_light, light);
        else extremes.far_light = max(extremes.far_light, light);
    } while (++i < THIN_SIDE * THIN_SIDE);
    return extremes;
}

// Number of nearer pixels above, below, left and right.
float nearer_beside(ivec2 at, float far_coc) {
    float count = 0.0;
    for (int k = 1; k < 9; k += 2) count += is_in_front(coc_at(neighbor(at, k)), far_coc) ? 1.0 : 0.0;
    return count;
}

// True beside a nearer surface that ends again after one or two pixels, and beside whose edge no pixel shows it alone.
bool is_beside_thin(ivec2 at, float coc) {
    uint ending = 0u;  // bits of neighbors at such a surface; examined last, because that takes longer
    for (int k = 0; k < 9; ++k) ending |= uint(ends_in(at, k, coc)) << k;
    bool is_thin = false;
    while (ending != 0u && !is_thin) {
        vec3 own;
        is_thin = !unmix_near(neighbor(at, lowest_bit(ending)), own);
        ending &= ending - 1u;
    }
    return is_thin;
}

// Unmixes a pixel. `far_coc` is that of the surface behind. The confidence is 0 unless `is_thin`.
Mixture thin_mixture(ivec2 at, float far_coc, bool is_thin) {
    vec3 x = color_at(at);
    Extremes extremes = extremes_around(at, far_coc, is_thin);
    float ratio = extremes.far_light / max(extremes.near_light, 1e-3);
    Mixture best = Mixture(x, x, 1.0, is_thin ? smoothstep(BRIGHTER_FROM, BRIGHTER_FULL, ratio) : 0.0);
    float least = HALF_MAX, missed_price = is_in_front(coc_at(at), far_coc) ? 0.0 : MISSED_PRICE;
    int i = best.sure > 0.0 ? 0 : THIN_SIDE * THIN_SIDE - 1;  // one round, as above, if the result is not used
    do {
        ivec2 offset = offset_of(i), p = inside(at + offset);
        vec3 far = color_at(p);
        float mixed_price = MIXED_PRICE * nearer_beside(p, far_coc);
        if (is_in_front(coc_at(p), far_coc)) {
#ifdef LISTS
            vec4 hidden = hidden_surface(p, far_coc);
            if (hidden.a < OPAQUE) continue;
            far = hidden.rgb;
            mixed_price = 0.0;
#else
            continue;
#endif
        }
        vec3 across = extremes.darkest - far;
        float squared = dot(across, across), cover = clamp(dot(x - far, across) / max(squared, 1e-5), 0.0, 1.0);
        vec3 residual = x - far - cover * across;
        float price = dot(residual, residual) / (squared + 0.01) + missed_price * max(cover - MISSED_COVERAGE, 0.0);
        price += DISTANCE_PRICE * length(vec2(offset)) + mixed_price;
        if (price >= least) continue;
        least = price;
        best = Mixture(extremes.darkest, far, cover, best.sure);
    } while (++i < THIN_SIDE * THIN_SIDE);
    return best;
}

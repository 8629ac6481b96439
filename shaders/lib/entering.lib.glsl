// Lets a surface that passes into a layer become known to the guess gradually, so that nothing jumps in a focus pull.
//
// The nearer layer shows the surface until this layer has it, and both guess what it is behind still nearer things. While
// both show it, what they guess is too dark or too bright. So there are two rounds. In the first, the ends are pixels of
// surfaces that this layer has in full. In the second, pixels of the entering surface are ends too, and the guess with
// them is mixed with the first one, by as much as the nearer layer has released.
//
//   coverage   how far the nearer layer covers this one at an end (lib/layer.lib.glsl)
//   free       1 - coverage
//   entering   a pixel of a surface that passes into the layer; its visibility is between KNOWN and END

#include "lib/hidden.lib.glsl"  // DIRECTION
#include "lib/layer.lib.glsl"  // END, coverage, visibility

#ifdef ENTERED
const bool is_entered = true;  // a surface passes into the layer, and there are two rounds
uniform bool is_second_round;
#else
const bool is_entered = false;
const bool is_second_round = false;
#endif
uniform sampler2D coc_tx;      // with ENTERED: r signed coc of the picture, of the size of the layer

// How far the nearer layer leaves a pixel of this visibility free, 0..1.
float free_share(float visible) { return visible < END ? 1.0 - coverage(1.0 - visible) : 1.0; }

// The same for a pixel; 1 if no surface passes into the layer.
float free_share_at(ivec2 at) { return is_entered ? free_share(visibility(texelFetch(coc_tx, at, 0).r)) : 1.0; }

// The free shares of the entering ends ahead and back of a pixel along direction k, times their weights, and the sum of
// these weights. `ends` has the steps to the ends; 0 for none.
vec2 entering_of(ivec2 at, int k, ivec2 ends, vec2 weight) {
    vec2 sum = vec2(0.0);
    for (int i = 0; i < 2; ++i) {
        float visible = visibility(texelFetch(coc_tx, at + (i == 0 ? ends.x : -ends.y) * DIRECTION[k], 0).r);
        if (ends[i] > 0 && visible < END) sum += weight[i] * vec2(free_share(visible), 1.0);
    }
    return sum;
}

// True if any end of a pixel is entering.
bool has_entering(ivec2 at, ivec2 ends[HIDDEN_DIRECTIONS]) {
    float weights = 0.0;
    int k = 0;
    do weights += entering_of(at, k, ends[k], vec2(1.0)).y; while (is_second_round && ++k < HIDDEN_DIRECTIONS);
    return weights > 0.0;
}

// The share of the second guess, 0..1, so that both layers together show the surface as far as each alone does. `entering`
// is the sum of `entering_of` over all directions, and `shown` how far the guess shows the surface, 0..1.
float share_of_entering(vec2 entering, float shown) {
    float free = entering.x / max(entering.y, 1e-30);
    return free / max(1.0 - shown * (1.0 - free), 1e-6);
}

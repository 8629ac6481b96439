// The pyramid from which surfaces behind the focus are guessed (render/defocus/far_guess.py). All levels are in one
// texture. A texel has the rgb of a surface behind the focus, and in alpha its coc in pixels, which is 0 where no
// surface is known.

uniform sampler2D levels_tx;

bool is_known(vec4 surface) { return surface.a > 0.0; }

// The mean of the known texels of the next coarser level around a pixel of the finer one, weighted bilinearly; 0 if
// none of them is known. `rect` is where the coarser level lies in the texture: xy corner, zw size.
vec4 coarser_at(ivec2 at, ivec4 rect) {
    vec2 middle = (vec2(at) + 0.5) / 2.0 - 0.5;
    ivec2 low = ivec2(floor(middle));
    vec2 fraction = middle - vec2(low);
    vec4 sum = vec4(0.0);
    float weight_sum = 0.0;
    for (int k = 0; k < 4; ++k) {
        ivec2 corner = ivec2(k & 1, k >> 1);
        vec4 surface = texelFetch(levels_tx, rect.xy + clamp(low + corner, ivec2(0), rect.zw - 1), 0);
        vec2 weights = mix(1.0 - fraction, fraction, vec2(corner));
        float weight = weights.x * weights.y * float(is_known(surface));
        sum += weight * surface;
        weight_sum += weight;
    }
    return weight_sum > 0.0 ? sum / weight_sum : vec4(0.0);
}

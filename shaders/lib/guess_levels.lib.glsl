// The pyramid from which surfaces behind the focus are guessed (render/defocus/far_guess.py). A texel has rgb and coc
// of a surface behind the focus; it is 0 where nothing is known.

uniform sampler2D levels_tx;

bool is_known(vec4 surface) { return surface.a > 0.0; }

// The mean of the known texels of a coarser level around a pixel of the finer one, weighted bilinearly.
vec4 coarser_at(ivec2 at, ivec4 place) {
    vec2 middle = (vec2(at) + 0.5) / 2.0 - 0.5;
    ivec2 low = ivec2(floor(middle));
    vec2 past = middle - vec2(low);
    vec4 sum = vec4(0.0);
    float whole = 0.0;
    for (int k = 0; k < 4; ++k) {
        ivec2 beside = ivec2(k & 1, k >> 1);
        vec4 surface = texelFetch(levels_tx, place.xy + clamp(low + beside, ivec2(0), place.zw - 1), 0);
        vec2 near = mix(1.0 - past, past, vec2(beside));
        float weight = near.x * near.y * float(is_known(surface));
        sum += weight * surface;
        whole += weight;
    }
    return whole > 0.0 ? sum / whole : vec4(0.0);
}

// Finds the pixels that need no more samples (done), because their samples and those of their neighbors agree so well
// that more would make no visible difference.
//
// Input
//   spread_tx     r mean luminance, g standard deviation of the samples of each pixel
// Output
//   out_done_img  1 where a pixel is done, else 0

layout(local_size_x = PIXEL_GROUP, local_size_y = PIXEL_GROUP) in;

uniform sampler2D spread_tx;
uniform float spread_max;  // largest standard deviation to accept, as a share of the luminance
uniform int reach;         // how many pixels around a pixel must be done with it
uniform int margin_px;     // pixels on every side that only a wide disc brings into the frame
uniform float spread_max_far;  // standard deviation that is accepted there, whatever the light
layout(r16f) uniform writeonly image2D out_done_img;

#define STEP 2.0  // difference between neighboring pixels that is an edge, in largest accepted deviations

// Luminance and standard deviation at a pixel; beyond the border those of the nearest pixel.
vec2 spread_at(ivec2 at) {
    return texelFetch(spread_tx, clamp(at, ivec2(0), textureSize(spread_tx, 0) - 1), 0).rg;
}

// True if the samples of a pixel differ, or if one of the four next pixels differs from it: an edge exactly between two
// pixels shows in the samples of neither.
bool is_noisy(ivec2 at) {
    vec2 own = spread_at(at);
    ivec2 inside = min(at, textureSize(spread_tx, 0) - 1 - at);
    float least = min(inside.x, inside.y) < margin_px ? spread_max_far : 0.0;
    bool is_uneven = own.g > max(spread_max * own.r, least);
    for (int i = 0; i < 4; ++i) {
        float next = spread_at(at + (2 * (i % 2) - 1) * ivec2(i / 2, 1 - i / 2)).r;
        is_uneven = is_uneven || abs(next - own.r) > STEP * max(spread_max * min(own.r, next), least);
    }
    return is_uneven;
}

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy), size = imageSize(out_done_img);
    if (any(greaterThanEqual(at, size))) return;
    bool noisy = false;
    for (int y = -reach; y <= reach && !noisy; ++y)
        for (int x = -reach; x <= reach; ++x)
            noisy = noisy || is_noisy(at + ivec2(x, y));
    imageStore(out_done_img, at, vec4(noisy ? 0.0 : 1.0));
}

// Shows a preview on the screen, with the fine detail of areas in focus added from the plate.
//
// The detail that the preview lacks is the difference between the plate and the plate at preview size. It is added
// where the circle of confusion is small and the preview shows the same as the plate. Where it shows something else, a
// blurred foreground spills over an area in focus, and hides the detail too.
//
// Inputs
//   picture_tx   the preview, rgb display values
//   plate_tx     the plate, rgb display values
//   coarse_tx    the parts of the plate in focus, at the size of the preview (focus_mean.comp.glsl), rgb display values
//   depth_tx     r depth of the plate in meters, or its signed coc (circle of confusion) in pixels if is_coc
// Output
//   out_color    rgb display values at a pixel of the screen, alpha 1

#include "lib/focus_share.lib.glsl"  // focus_share, share_of, signed_px

uniform sampler2D picture_tx;
uniform sampler2D plate_tx;
uniform sampler2D coarse_tx;
uniform sampler2D depth_tx;
uniform vec2 first_px;         // corners of the picture, in pixels of the screen, y down
uniform vec2 last_px;
uniform vec2 screen_px;        // size of the screen

out vec4 out_color;

// Differences between preview and coarse plate, in display values: from BARE on the foreground begins to hide the
// detail, from HIDDEN on it hides all of it. These values give previews the lowest mean FLIP error.
#define BARE 0.06
#define HIDDEN 0.25

// Share of the detail at a pixel of the plate. Beside a blurred foreground the plate's pixel has some of the color of
// that foreground, which would show its silhouette as a thin line; it has no detail.
float detail_share(ivec2 texel, ivec2 size) {
    const ivec2 BESIDE[4] = ivec2[](ivec2(-1, 0), ivec2(1, 0), ivec2(0, -1), ivec2(0, 1));
    float depth = texelFetch(depth_tx, texel, 0).r, nearest = depth;
    for (int k = 0; k < 4; ++k)
        nearest = min(nearest, texelFetch(depth_tx, clamp(texel + BESIDE[k], ivec2(0), size - 1), 0).r);
    float near_px = max(-signed_px(nearest, texel), 0.0);  // the nearest is the most blurred of those in front
    return min(focus_share(depth, texel), share_of(near_px));
}

void main() {
    vec2 at = vec2(gl_FragCoord.x, screen_px.y - gl_FragCoord.y);
    vec2 texture_uv = (at - first_px) / (last_px - first_px);
    ivec2 size = textureSize(depth_tx, 0);
    ivec2 texel = clamp(ivec2(floor(texture_uv * vec2(size))), ivec2(0), size - 1);
    vec3 preview = texture(picture_tx, texture_uv).rgb, coarse = texture(coarse_tx, texture_uv).rgb;
    vec3 difference = abs(preview - coarse);
    float hidden = smoothstep(BARE, HIDDEN, max(difference.r, max(difference.g, difference.b)));
    float share = (1.0 - hidden) * detail_share(texel, size);
    out_color = vec4(preview + share * (texture(plate_tx, texture_uv).rgb - coarse), 1.0);
}

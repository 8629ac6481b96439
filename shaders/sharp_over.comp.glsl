// What is in focus, from the plate itself, to lie over a preview that was made smaller.
//
// A smaller preview softens what is sharp. With a single layer nothing spills over what is in focus,
// so that the plate's own pixels are right there, and the hand sees what it focuses on.
//
// Input
//   plate_tx         the plate as the display shows it
//   depth_tx         metres, or signed coc in pixels where `is_coc`
// Output
//   out_sharp_img    display RGB, straight alpha 1 in focus to 0 where the preview is as sharp

layout(local_size_x = 16, local_size_y = 16) in;

uniform sampler2D plate_tx;
uniform sampler2D depth_tx;
layout(rgba8) uniform writeonly image2D out_sharp_img;
uniform bool is_coc;
uniform float at_infinity_px;  // signed coc over dioptres: at_infinity + per_dioptre / depth
uniform float per_dioptre_px;
uniform float texel_px;        // side of a pixel of the preview, in pixels of the plate

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(at, textureSize(depth_tx, 0)))) return;
    float depth = texelFetch(depth_tx, at, 0).r;
    float coc = is_coc ? depth : at_infinity_px + per_dioptre_px / depth;
    float alpha = 1.0 - smoothstep(0.25, 1.0, abs(coc) / texel_px);
    imageStore(out_sharp_img, at, vec4(texelFetch(plate_tx, at, 0).rgb, alpha));
}

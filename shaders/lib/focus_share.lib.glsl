// Share of a pixel's detail that a preview shows: all of it if the circle of confusion is smaller than half a
// pixel of the preview, none from one and a half pixels on.

uniform bool is_coc;           // the depth is the signed coc in pixels; else metres
uniform float at_infinity_px;  // signed coc over dioptres: at_infinity + per_dioptre / depth
uniform float per_dioptre_px;
uniform float texel_px;        // side of a pixel of the preview, in pixels of the plate

float focus_share(float depth) {
    float coc = is_coc ? depth : at_infinity_px + per_dioptre_px / depth;
    return 1.0 - smoothstep(0.5, 1.5, abs(coc) / texel_px);
}

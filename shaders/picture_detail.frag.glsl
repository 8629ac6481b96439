// Shows a preview on the screen, with the fine detail of areas in focus added from the plate.
//
// The difference between the plate and the plate at preview size is the detail that the preview lacks.
// It is added where the circle of confusion is small. The preview's own light is kept, so a blurred
// foreground that spills over areas in focus stays.
//
// Inputs
//   picture_tx   the preview, display values
//   plate_tx     the plate, display values
//   coarse_tx    the plate at the preview's size, display values
//   depth_tx     of the plate: metres, or signed coc in pixels where `is_coc`
// Output
//   out_color    the same where the pixel of the screen lies in the picture

uniform sampler2D picture_tx;
uniform sampler2D plate_tx;
uniform sampler2D coarse_tx;
uniform sampler2D depth_tx;
uniform vec2 first_px;         // corners of the picture, in pixels of the screen, y down
uniform vec2 last_px;
uniform vec2 screen_px;
uniform bool is_coc;
uniform float at_infinity_px;  // signed coc over dioptres: at_infinity + per_dioptre / depth
uniform float per_dioptre_px;
uniform float texel_px;        // side of a pixel of the preview, in pixels of the plate

out vec4 out_color;

void main() {
    vec2 at = vec2(gl_FragCoord.x, screen_px.y - gl_FragCoord.y);
    vec2 place = (at - first_px) / (last_px - first_px);
    ivec2 size = textureSize(depth_tx, 0);
    ivec2 texel = clamp(ivec2(floor(place * vec2(size))), ivec2(0), size - 1);
    float depth = texelFetch(depth_tx, texel, 0).r;
    float coc = is_coc ? depth : at_infinity_px + per_dioptre_px / depth;
    float share = 1.0 - smoothstep(0.5, 1.5, abs(coc) / texel_px);
    vec3 detail = texture(plate_tx, place).rgb - texture(coarse_tx, place).rgb;
    out_color = vec4(texture(picture_tx, place).rgb + share * detail, 1.0);
}

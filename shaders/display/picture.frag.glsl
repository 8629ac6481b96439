// Draws a picture on the screen, with its first row at the top, in the rectangle of picture.vert.glsl.
//
// Input
//   picture_tx   rgb display values, straight alpha
// Output
//   out_color    the same, at a pixel of the screen

uniform sampler2D picture_tx;
uniform vec2 first_px;    // corners of the picture, in pixels of the screen, y down
uniform vec2 last_px;
uniform vec2 screen_px;   // size of the screen
uniform bool is_nearest;  // show texels as squares; else use the texture's filter

out vec4 out_color;

void main() {
    vec2 at = vec2(gl_FragCoord.x, screen_px.y - gl_FragCoord.y);
    vec2 texture_uv = (at - first_px) / (last_px - first_px);
    ivec2 size = textureSize(picture_tx, 0);
    ivec2 texel = clamp(ivec2(floor(texture_uv * vec2(size))), ivec2(0), size - 1);
    out_color = is_nearest ? texelFetch(picture_tx, texel, 0) : texture(picture_tx, texture_uv);
}

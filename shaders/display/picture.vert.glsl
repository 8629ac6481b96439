// Draws the rectangle that a picture fills on the screen. The fragment shader colors its pixels.

uniform vec2 first_px;   // its corners, in pixels of the screen, y down
uniform vec2 last_px;
uniform vec2 screen_px;  // size of the screen

void main() {
    vec2 corner = vec2(gl_VertexID % 2, gl_VertexID / 2);
    vec2 at = mix(first_px, last_px, corner) / screen_px;
    gl_Position = vec4(2.0 * at.x - 1.0, 1.0 - 2.0 * at.y, 0.0, 1.0);
}

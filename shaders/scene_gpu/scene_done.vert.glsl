// Draws a triangle over the whole picture, in front of everything.

void main() {
    vec2 at = vec2(gl_VertexID % 2, gl_VertexID / 2) * 4.0 - 1.0;
    gl_Position = vec4(at, -1.0, 1.0);
}

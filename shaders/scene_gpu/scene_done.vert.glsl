// Draws a triangle over the whole picture at the nearest depth. scene_done.frag.glsl keeps it only in pixels that need
// no more samples, so that the depth test rejects all later draws there.

void main() {
    vec2 at = vec2(gl_VertexID % 2, gl_VertexID / 2) * 4.0 - 1.0;
    gl_Position = vec4(at, -1.0, 1.0);
}

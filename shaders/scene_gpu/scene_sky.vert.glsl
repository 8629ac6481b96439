// Draws a triangle over the whole picture at the far plane, so that the sky (scene_sky.frag.glsl) shows only where
// nothing is in front of it.

uniform mat3 world_from_screen;  // maps x, y in -1..1 and 1 to the viewing direction there

out vec3 direction;  // viewing direction, not unit

void main() {
    vec2 at = vec2(gl_VertexID % 2, gl_VertexID / 2) * 4.0 - 1.0;
    direction = world_from_screen * vec3(at, 1.0);
    gl_Position = vec4(at, 1.0, 1.0);
}

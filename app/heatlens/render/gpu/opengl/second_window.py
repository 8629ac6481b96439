"""The device of a second window, which shares textures with the first and only copies them."""

import moderngl

from heatlens.render.gpu.resources import Texture

_COPY_VERTEX = """#version 330
out vec2 at;
void main() {
    at = vec2(gl_VertexID & 1, gl_VertexID >> 1);
    gl_Position = vec4(2.0 * at - 1.0, 0.0, 1.0);
}
"""
_COPY_FRAGMENT = """#version 330
uniform sampler2D picture_tx;
in vec2 at;
out vec4 color;
void main() { color = vec4(texture(picture_tx, at).rgb, 1.0); }
"""


class SecondWindow:
    """Copies textures of the first window to the second one, which must be current at each call."""

    def __init__(self) -> None:
        self._ctx = moderngl.create_context(require=330)
        program = self._ctx.program(vertex_shader=_COPY_VERTEX, fragment_shader=_COPY_FRAGMENT)
        self._quad = self._ctx.vertex_array(program, [])
        self._shared: moderngl.Texture | None = None  # the picture in this window's context

    def show(self, texture: Texture, size: tuple[int, int]) -> None:
        """Fill the window, of `size` pixels, with a texture of 4 bytes a texel."""
        self._ctx.screen.use()
        self._ctx.screen.viewport = (0, 0, *size)
        self._shared = self._share_texture(texture)
        self._shared.filter = (moderngl.NEAREST, moderngl.NEAREST)
        self._shared.use(0)
        self._quad.render(moderngl.TRIANGLE_STRIP, vertices=4)

    def _share_texture(self, texture: Texture) -> moderngl.Texture:
        """Return the texture in this window's context; each new object leaks a few bytes."""
        shared = self._shared
        if shared is not None and (shared.glo, shared.size) == (texture.handle, texture.size):
            return shared
        return self._ctx.external_texture(texture.handle, texture.size, 4, 0, "f1")

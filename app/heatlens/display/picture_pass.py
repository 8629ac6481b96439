"""Pictures laid on the screen, every texel where it belongs.

ImGui's own OpenGL backend would do it with a sampler that smears large pixels and has no mipmaps.
"""

from collections.abc import Iterable
from dataclasses import dataclass

import moderngl

from heatlens.gpu.program import DrawProgram
from heatlens.model.boxes import Box
from heatlens.model.view_geometry import Point

# Straight alpha over what lies below; the screen stays opaque, or the desktop would shine through.
_OVER = (moderngl.SRC_ALPHA, moderngl.ONE_MINUS_SRC_ALPHA, moderngl.ZERO, moderngl.ONE)


@dataclass(frozen=True, eq=False)
class Laid:
    """A picture and where it lies, in pixels of the screen, y down.

    texture      display values, straight alpha
    first, last  its corners
    clip         nothing is drawn outside
    is_nearest   texels are squares; else the texture's filter counts
    is_opaque    its alpha is 1
    """

    texture: moderngl.Texture
    first: Point
    last: Point
    clip: Box
    is_nearest: bool
    is_opaque: bool


class PicturePass:
    """Draws pictures over each other."""

    def __init__(self, ctx: moderngl.Context) -> None:
        self._ctx = ctx
        self._program = DrawProgram(ctx, "picture")
        self._quad = self._program.vertex_array([])

    def run(
        self, laid: Iterable[Laid], target: moderngl.Framebuffer, screen_px: tuple[int, int]
    ) -> None:
        """Draw `laid`, the lowest first, into `target`, whose last row is the top of the screen."""
        target.use()
        target.viewport = (0, 0, *screen_px)
        self._ctx.blend_func = _OVER  # type: ignore[assignment]  # its stub knows two of the four
        for picture in laid:
            if not picture.clip.is_empty:
                self._draw(picture, target, screen_px)
        target.scissor = None  # type: ignore[assignment]  # its stub does not know that
        self._ctx.enable_only(moderngl.NOTHING)

    def _draw(
        self, picture: Laid, target: moderngl.Framebuffer, screen_px: tuple[int, int]
    ) -> None:
        clip = picture.clip
        target.scissor = (clip.x0, screen_px[1] - clip.y1, clip.width, clip.height)
        self._ctx.enable_only(moderngl.NOTHING if picture.is_opaque else moderngl.BLEND)
        self._program.bind(
            textures={"picture_tx": picture.texture},
            uniforms={
                "first_px": picture.first,
                "last_px": picture.last,
                "screen_px": screen_px,
                "is_nearest": picture.is_nearest,
            },
        )
        self._quad.render(moderngl.TRIANGLE_STRIP, vertices=4)

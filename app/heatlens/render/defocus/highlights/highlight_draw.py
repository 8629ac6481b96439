"""Draw the list of discs into the picture."""

from collections.abc import Iterator

from heatlens.render.defocus.cutout_pass import SharpPart
from heatlens.render.defocus.highlights.highlight_list import HighlightBuffers
from heatlens.render.defocus.highlights.highlight_shadow import RayMemory, ray_textures
from heatlens.render.defocus.listed_fragments import list_buffers, list_uniforms
from heatlens.render.defocus.optics import Optics
from heatlens.render.defocus.unmix_pass import UnmixedPicture
from heatlens.render.gpu.context import is_software
from heatlens.render.gpu.device import Device
from heatlens.render.gpu.draw_target import DrawTarget
from heatlens.render.gpu.framebuffer import Blend, Primitive
from heatlens.render.gpu.program import DrawProgram, VertexArray
from heatlens.render.gpu.resources import Buffer, Texture
from heatlens.render.gpu.textures import OpeningTextures

_PIXELS_A_BAND = 1 << 17  # drawn in a step, because hundreds of discs may overlap there


class HighlightDrawPass:
    """Draws the list of discs into the picture."""

    def __init__(self, ctx: Device) -> None:
        self._ctx = ctx
        self._program = DrawProgram(ctx, "defocus/highlight_draw")
        self._quads: dict[DrawProgram, tuple[Buffer, VertexArray]] = {}
        self._target = DrawTarget(ctx)
        self._is_drawn_in_bands = is_software(ctx)
        self._openings = OpeningTextures(ctx)

    def steps(
        self,
        buffers: HighlightBuffers,
        picture: UnmixedPicture,
        optics: Optics,
        rays: RayMemory,
        color: Texture,
        sharp: SharpPart | None = None,
    ) -> Iterator[None]:
        """Add every disc of the list to `color`, except where `picture` or `sharp` hides it.

        `color` may be a whole number of times as large as `picture`. `rays` is the output of
        `HighlightShadowPass`.
        On a software rasterizer discs are drawn in bands, so that many large ones do not hold up
        the window.
        """
        width, height = color.size
        rows = max(1, _PIXELS_A_BAND // width) if self._is_drawn_in_bands else height
        for first in range(0, height, rows):
            band = (0, first, width, rows)
            for is_large in (False, True):
                self._draw_band(buffers, picture, optics, rays, color, band, sharp, is_large)
            yield

    def _draw_band(
        self,
        buffers: HighlightBuffers,
        picture: UnmixedPicture,
        optics: Optics,
        rays: RayMemory,
        color: Texture,
        band: tuple[int, int, int, int],
        sharp: SharpPart | None,
        is_large: bool,
    ) -> None:
        """Draw the large discs or all others, but only into `band` (x, y, width, height).

        All state of the device that other draws may have changed is set again.
        """
        has_lists = picture.lists is not None
        program = self._program.version(LISTS=has_lists, LARGE=is_large, **optics.disc.switches)
        quads = self._quads_of(program, buffers.sprite)
        target, enlarged = self._target.around(color), color.width / picture.coc.width
        target.use()
        target.scissor = band
        program.bind(
            textures=ray_textures(picture, rays)
            | {
                "near_tx": picture.near,
                "cutout_tx": picture.color if sharp is None else sharp.light,
                "cutout_coc_tx": picture.coc if sharp is None else sharp.coc,
            }
            | self._openings.of(optics.disc.aperture),
            uniforms=optics.disc.uniforms
            | {"picture_size": picture.coc.size, "nearest_px": optics.nearest_px}
            | {"enlarged": enlarged, "has_cutout": sharp is not None}
            | list_uniforms(picture.lists),
            buffers=list_buffers(picture.lists) | {"pixel_list_block": rays.nodes},
        )
        self._ctx.draw_with(Blend.ADD)
        quads.render_indirect(buffers.plan, Primitive.TRIANGLE_STRIP, 1)
        self._ctx.draw_with()
        target.scissor = None

    def _quads_of(self, program: DrawProgram, sprites: Buffer) -> VertexArray:
        """Return the vertex array of a program for the buffer of discs.

        The latest array of each program is kept, and replaced if the buffer is another one.
        """
        cached = self._quads.get(program)
        if cached is None or cached[0] is not sprites:
            if cached is not None:
                cached[1].release()
            layout = [(sprites, "4f 4f 4f/i", "in_disc", "in_light", "in_nodes")]
            cached = sprites, program.vertex_array(layout)
            self._quads[program] = cached
        return cached[1]

"""Draw pictures on the screen at exact positions.

ImGui's own OpenGL backend uses a sampler that blurs enlarged pixels and has no mipmaps. A small
picture is sharpened before it is drawn enlarged, to compensate for bilinear filtering. The part of
a plate that is in focus is averaged at the size of a preview.
"""

from collections.abc import Iterable
from dataclasses import dataclass

from heatlens.core.model.boxes import Box
from heatlens.core.model.focus.coc import NO_LINE, CocLine
from heatlens.core.model.view.view_geometry import Point
from heatlens.render.gpu.device import Device
from heatlens.render.gpu.framebuffer import Blend, Framebuffer, Primitive
from heatlens.render.gpu.program import (
    ComputeProgram,
    DrawProgram,
    blocks_for,
    groups_for,
    pixel_groups,
)
from heatlens.render.gpu.resources import Image, Texture

TILE_PX = 8  # side of the tiles of a preview that are drawn with or without detail
STRIP_PX = 4  # pixels that an invocation sharpens


@dataclass(frozen=True, eq=False)
class Detail:
    """The detail in focus that a preview is too small to show.

    plate    the plate, display values
    coarse   the part of the plate in focus, at the preview's size, display values
    shares   alpha: the greatest share of the detail under each pixel of the preview
    depth    of the plate: meters, or signed coc in pixels where `line` is None
    line     signed coc over dioptres, in pixels of `depth`
    texel_px size of a pixel of the preview, in pixels of `depth`
    """

    plate: Texture
    coarse: Texture
    shares: Texture
    depth: Texture
    line: CocLine | None
    texel_px: float


@dataclass(frozen=True, eq=False)
class PlacedPicture:
    """A picture and its position, in pixels of the screen, y down.

    texture      display values, straight alpha
    first, last  its corners
    clip         nothing is drawn outside of this rectangle
    is_nearest   texels are drawn as squares; else the texture's filter is used
    is_opaque    its alpha is 1
    detail       added where the picture is in focus; such a picture is opaque
    """

    texture: Texture
    first: Point
    last: Point
    clip: Box
    is_nearest: bool
    is_opaque: bool
    detail: Detail | None = None


class PicturePass:
    """Draws pictures over each other."""

    def __init__(self, ctx: Device) -> None:
        self._ctx = ctx
        self._program = DrawProgram(ctx, "display/picture")
        self._detail_program = DrawProgram(ctx, "display/picture_detail", defines={"TILE": TILE_PX})
        self._quad = self._program.vertex_array([])
        self._tiles = self._detail_program.vertex_array([])

    def run(
        self, pictures: Iterable[PlacedPicture], target: Framebuffer, screen_px: tuple[int, int]
    ) -> None:
        """Draw `pictures`, the lowest first, into `target`, whose last row is the top."""
        target.use()
        target.viewport = (0, 0, *screen_px)
        for picture in pictures:
            if not picture.clip.is_empty:
                self._draw(picture, target, screen_px)
        target.scissor = None
        self._ctx.draw_with()

    def _draw(
        self, picture: PlacedPicture, target: Framebuffer, screen_px: tuple[int, int]
    ) -> None:
        """Draw one picture, with its detail if it has one, only inside its clip."""
        clip = picture.clip  # y down, while the rows of the target run up
        target.scissor = (clip.x0, screen_px[1] - clip.y1, clip.width, clip.height)
        self._ctx.draw_with(Blend.NONE if picture.is_opaque else Blend.OVER)
        place: dict[str, object] = {
            "first_px": picture.first,
            "last_px": picture.last,
            "screen_px": screen_px,
        }
        is_nearest = picture.is_nearest and picture.detail is None
        self._program.bind(
            textures={"picture_tx": picture.texture}, uniforms={**place, "is_nearest": is_nearest}
        )
        self._quad.render(Primitive.TRIANGLE_STRIP, vertices=4)
        if picture.detail is not None:
            self._draw_detail(picture.texture, picture.detail, place)

    def _draw_detail(self, preview: Texture, detail: Detail, place: dict[str, object]) -> None:
        """Draw the parts of a preview that have some detail over it."""
        textures: dict[str, Image] = {
            "picture_tx": preview,
            "plate_tx": detail.plate,
            "coarse_tx": detail.coarse,
            "shares_tx": detail.shares,
            "depth_tx": detail.depth,
        }
        focus = focus_uniforms(detail.line, detail.texel_px)
        self._detail_program.bind(textures=textures, uniforms=place | focus)
        across, down = blocks_for(detail.shares.size, TILE_PX)
        self._tiles.render(Primitive.TRIANGLES, vertices=6 * across * down)


class EnlargePass:
    """Compensates in advance for the softness of bilinear enlargement."""

    def __init__(self, ctx: Device) -> None:
        self._program = ComputeProgram(ctx, "display/enlarge_ready.comp.glsl", {"STRIP": STRIP_PX})

    def run(self, picture: Texture, out: Texture) -> None:
        """Write `picture`, display values, to `out` of the same size, RGBA of 8 bits."""
        strips = out.width, groups_for(out.height, STRIP_PX)
        self._program.dispatch(
            pixel_groups(strips), textures={"picture_tx": picture}, images={"out_img": out}
        )


class DepthRangePass:
    """Finds the least and the greatest depth under each pixel of a preview."""

    def __init__(self, ctx: Device) -> None:
        self._program = ComputeProgram(ctx, "display/depth_range.comp.glsl")

    def run(self, depth: Texture, out: Texture) -> None:
        """Write the range of `depth` to the red and green of `out`, at the preview's size."""
        self._program.dispatch(
            pixel_groups(out.size), textures={"depth_tx": depth}, images={"out_img": out}
        )


@dataclass(frozen=True, eq=False)
class CoarsePlate:
    """A plate at the size of a preview, whatever is in focus.

    mean      its light, premultiplied
    range     red and green: the least and the greatest depth under each pixel
    diffused  the same light times `scale`, without the highlights that the preview draws as discs;
              None if it draws none
    """

    mean: Texture
    range: Texture
    diffused: Texture | None = None
    scale: float = 1.0


class FocusMeanPass:
    """Averages the pixels in focus under each pixel of a preview."""

    def __init__(self, ctx: Device) -> None:
        self._program = ComputeProgram(ctx, "display/focus_mean.comp.glsl")

    def run(
        self,
        color: Texture,
        depth: Texture,
        line: CocLine | None,
        coarse: CoarsePlate,
        out: Texture,
    ) -> None:
        """Write the mean of the focused part of `color` to `out`, and to its alpha the share.

        The mean is without the highlights that the preview draws as discs.

        `depth` holds meters, or signed coc in pixels if `line` is None. `coarse` is of the same
        plate, and has the size of `out`.
        """
        self._program.dispatch(
            pixel_groups(out.size),
            textures={
                "color_tx": color,
                "depth_tx": depth,
                "mean_tx": coarse.mean,
                "diffused_tx": coarse.diffused or coarse.mean,
                "range_tx": coarse.range,
            },
            images={"out_img": out},
            uniforms=focus_uniforms(line, depth.width / out.width)
            | {"diffused_scale": coarse.scale if coarse.diffused is not None else 1.0},
        )


def focus_uniforms(line: CocLine | None, texel_px: float) -> dict[str, object]:
    """Return the uniforms of lib/focus_share.lib.glsl."""
    return {"is_coc": line is None, **(line or NO_LINE).uniforms, "texel_px": texel_px}

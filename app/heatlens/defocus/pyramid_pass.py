"""Compute depth of field from a pyramid of ever smaller pictures, read at the level of the blur.

Burt and Adelson 1983 make the levels, Williams 1983 reads between them.
"""

from collections.abc import Iterator

import moderngl

from heatlens.defocus.optics import Optics
from heatlens.gpu.program import ComputeProgram, pixel_groups
from heatlens.gpu.shader_constants import PYRAMID_LEVELS_MAX

Place = tuple[int, int, int, int]  # corner x, y and size x, y


def level_variance(level: int) -> float:
    """Return the variance, in pixels^2 along each axis, of a level that is read linearly.

    See pyramid_read.comp.glsl.
    """
    return (4.0**level - 1) / 2


def level_places(size: tuple[int, int], widest_px: float) -> list[Place]:
    """Return where levels 1, 2, .. lie in one texture, as many as discs `widest_px` across need.

    The first is on the left, all others in a column beside it. A level has one pixel more than half
    of the level below, for interpolation; below 2 pixels it would not shrink.
    """
    places: list[Place] = []
    width, height = size
    x = y = 0
    while len(places) < PYRAMID_LEVELS_MAX and level_variance(len(places)) < widest_px**2 / 16:
        if places and max(width, height) <= 2:
            break
        width, height = width // 2 + 1, height // 2 + 1
        places.append((x, y, width, height))
        x, y = (width, 0) if len(places) == 1 else (x, y + height)
    return places


def pyramid_size(places: list[Place]) -> tuple[int, int]:
    """Return the size of the texture that holds them, at least a pixel."""
    width = max((x + width for x, _, width, _ in places), default=1)
    return width, max((y + height for _, y, _, height in places), default=1)


def widest_px(optics: Optics) -> float:
    """Return the largest disc of the plate, along the shorter axis of discs."""
    return max(abs(optics.nearest_px), abs(optics.farthest_px)) * min(optics.disc.spreads)


class PyramidPass:
    """Makes the levels, then reads each pixel from two of them, whatever the blur.

    Sharp pixels bleed into blurred neighbours, because the pyramid ignores depth.
    """

    def __init__(self, ctx: moderngl.Context) -> None:
        self._reduce = ComputeProgram(ctx, "pyramid_reduce.comp.glsl")
        self._read = ComputeProgram(ctx, "pyramid_read.comp.glsl")

    def steps(
        self,
        color: moderngl.Texture,
        coc: moderngl.Texture,
        optics: Optics,
        pyramid: moderngl.Texture,
        out_color: moderngl.Texture,
    ) -> Iterator[None]:
        """Fill `out_color`, RGBA as `color`; `pyramid` holds the levels of `level_places`."""
        places = level_places(color.size, widest_px(optics))
        source, source_place = color, (0, 0, *color.size)
        for place in places:
            self._reduce.dispatch(
                pixel_groups(place[2:]),
                textures={"source_tx": source},
                images={"out_img": pyramid},
                uniforms={"source_place": source_place, "out_place": place},
            )
            source, source_place = pyramid, place
            yield
        self._read.dispatch(
            pixel_groups(color.size),
            textures={"color_tx": color, "pyramid_tx": pyramid, "coc_tx": coc},
            images={"out_color_img": out_color},
            uniforms={
                "aperture_axes": optics.disc.spreads,
                "places": places + [(0, 0, 1, 1)] * (PYRAMID_LEVELS_MAX - len(places)),
                "levels": len(places),
            },
        )
        yield

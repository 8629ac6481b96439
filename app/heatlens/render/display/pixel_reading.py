"""Read the values at a pixel: scene-linear colors, depth, circle of confusion, coordinates."""

import math
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from heatlens.core.model.boxes import Box
from heatlens.core.model.focus.coc import coc_px, far_limit_m, focus_offset_coc_px, near_limit_m
from heatlens.core.model.lens.lens import Lens, measured_text
from heatlens.media.plate.coc_line import line_of
from heatlens.media.plate.plate import Plate
from heatlens.render.gpu.device import Device
from heatlens.render.gpu.framebuffer import Framebuffer
from heatlens.render.gpu.resources import Texture
from heatlens.render.preview.shown import ShownPicture

_FOCUS_LEAST = 1.02  # nearest focus distance in focal lengths

Rgba = tuple[float, float, float, float]


@dataclass(frozen=True)
class PixelReading:
    """A pixel of the plate and of the picture through the lens."""

    display_px: tuple[int, int]  # counted from the display window's corner
    data_px: tuple[int, int]  # coordinates in the file
    plate: Rgba  # scene-linear, premultiplied, as in the file
    picture: Rgba  # the same pixel seen through the lens
    depth_m: float | None  # None if the plate holds circles of confusion
    coc_px: float  # signed diameter
    sharp_m: tuple[float, float] | None = None  # depth of field if the lens is focused here


class PictureReader:
    """Reads single pixels of a texture, and only when the pixel or the picture has changed."""

    def __init__(self, ctx: Device) -> None:
        self._ctx = ctx
        self._framebuffer: tuple[Texture, Framebuffer] | None = None
        self._last: tuple[object, Rgba] | None = None

    def pixel(self, shown: ShownPicture, version: object, at: tuple[int, int]) -> Rgba:
        """Return RGBA of the texel `at` (column, row) of the shown picture, as floats.

        `version` changes whenever the content of the texture does.
        """
        key = (version, shown.texture, at)
        if self._last is None or self._last[0] != key:
            box = (*at, 1, 1)
            data = self._bind_framebuffer(shown.texture).read(
                viewport=box, components=4, dtype="f4"
            )
            red, green, blue, alpha = np.frombuffer(data, np.float32).tolist()
            self._last = (key, (red, green, blue, alpha))
        return self._last[1]

    def _bind_framebuffer(self, texture: Texture) -> Framebuffer:
        """Return a framebuffer of `texture`, and keep it until another texture is read.

        The previous one is released only once the new one is bound.
        """
        previous = self._framebuffer
        if previous is not None and previous[0] is texture:
            return previous[1]
        self._framebuffer = (texture, self._ctx.framebuffer([texture]))
        self._framebuffer[1].use()
        if previous is not None:
            previous[1].release()
        return self._framebuffer[1]


def read_texels(
    ctx: Device, texture: Texture, box: Box, dtype: Literal["f1", "f4"]
) -> NDArray[np.generic]:
    """Return the texels in a box, (h, w, 4): bytes for "f1", float32 for "f4"."""
    target = ctx.framebuffer([texture])
    area = (box.x0, box.y0, box.width, box.height)
    data = target.read(viewport=area, components=4, dtype=dtype)
    target.release()
    kind = np.uint8 if dtype == "f1" else np.float32
    return np.frombuffer(data, kind).reshape(box.height, box.width, 4)


def reading_at(
    pixel: tuple[int, int],
    plate: Plate,
    lens: Lens,
    shown: ShownPicture,
    version: object,
    reader: PictureReader,
    frame_px: tuple[int, int] | None = None,
) -> PixelReading | None:
    """Return the values at a pixel of the display window; None outside the data window.

    `frame_px` is the pixel of the plate that is visible there, if it differs from `pixel`.
    """
    data, display = plate.data_window, plate.display_window
    # The same pixel in the coordinates of the file, then the plate's own in its data window.
    file_px = pixel[0] + display.x0, pixel[1] + display.y0
    x, y = pixel if frame_px is None else frame_px
    column, row = x + display.x0 - data.x0, y + display.y0 - data.y0
    if not (data.contains(*file_px) and data.contains(column + data.x0, row + data.y0)):
        return None
    pixel_box = Box(column, row, column + 1, row + 1)
    depth_m = plate.pixels.depth_in(pixel_box).item() if plate.has_distances else None
    width, height = shown.texture.size
    texel = (
        (file_px[0] - data.x0) * width // data.width,
        (file_px[1] - data.y0) * height // data.height,
    )
    red, green, blue, alpha = plate.pixels.color_in(pixel_box)[0, 0].tolist()
    return PixelReading(
        display_px=pixel,
        data_px=file_px,
        plate=(red, green, blue, alpha),
        picture=reader.pixel(shown, version, texel),
        depth_m=depth_m,
        coc_px=_coc_at(plate, lens, row, column, depth_m),
        sharp_m=_sharp_m(lens, depth_m),
    )


def _sharp_m(lens: Lens, depth_m: float | None) -> tuple[float, float] | None:
    """Return the near and the far limit of sharpness if the lens were focused at `depth_m`.

    Return None if there is no depth, or it is too near to be focused on.
    """
    if depth_m is None or not depth_m > _FOCUS_LEAST * lens.focal_length_mm * 1e-3:
        return None
    focused = replace(lens, focus_distance_m=depth_m)
    return near_limit_m(focused), far_limit_m(focused)


def visible_depth_m(plate: Plate, pixel: tuple[int, int]) -> float | None:
    """Return the distance in meters at a pixel of the display window.

    Return None for a plate without distances, and outside the data window.
    """
    data, display = plate.data_window, plate.display_window
    file_px = pixel[0] + display.x0, pixel[1] + display.y0
    if not (plate.has_distances and data.contains(*file_px)):
        return None
    column, row = file_px[0] - data.x0, file_px[1] - data.y0
    return plate.pixels.depth_in(Box(column, row, column + 1, row + 1)).item()


def _coc_at(plate: Plate, lens: Lens, row: int, column: int, depth_m: float | None) -> float:
    """Return the signed coc in pixels at a pixel: the plate's own, or that of `depth_m`."""
    if depth_m is None:
        assert plate.coc_px is not None
        return float(plate.coc_px[row, column])
    line, pixel_box = line_of(plate, lens), Box(column, row, column + 1, row + 1)
    return float(np.squeeze(coc_px(depth_m, line) + focus_offset_coc_px(line, pixel_box)))


def reading_text(reading: PixelReading, unit: str, lens: Lens) -> str:
    """Return one line for the status bar, with distances measured as `lens` does it."""
    x, y = reading.display_px
    position = f"x {x}  y {y}"
    if reading.data_px != reading.display_px:
        position += f"  (data window {reading.data_px[0]}, {reading.data_px[1]})"
    depth_m = reading.depth_m
    depth = "" if depth_m is None else f"   depth {_depth_text(lens, depth_m, unit)}"
    sharp = ""
    if reading.sharp_m is not None:
        near_m, far_m = reading.sharp_m
        sharp = (
            f"   focus here: {_depth_text(lens, near_m, unit)} to {_depth_text(lens, far_m, unit)}"
        )
    return (
        f"{position}   picture {_rgb_text(reading.picture)}   plate {_rgb_text(reading.plate)}"
        f"{depth}   blur {round(reading.coc_px, 2) + 0.0:+.2f} px{sharp}"
    )


def _depth_text(lens: Lens, depth_m: float, unit: str) -> str:
    return "infinite" if math.isinf(depth_m) else measured_text(lens, depth_m, unit)


def _rgb_text(value: Rgba) -> str:
    return " ".join(f"{channel:.4g}" for channel in value[:3])

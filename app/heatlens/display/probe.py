"""What is at a pixel: raw scene-linear values, depth, circle of confusion, coordinates."""

import math
from dataclasses import dataclass

import moderngl
import numpy as np

from heatlens.model.boxes import Box
from heatlens.model.coc import coc_line, coc_px
from heatlens.model.lens import Lens
from heatlens.model.units import format_distance
from heatlens.plate.plate import Plate
from heatlens.preview.shown import Shown

Rgba = tuple[float, float, float, float]


@dataclass(frozen=True)
class Probe:
    """A pixel of the plate and of the picture through the lens."""

    display_px: tuple[int, int]  # counted from the display window's corner
    data_px: tuple[int, int]  # as the file counts, data window coordinates
    plate: Rgba  # scene-linear, premultiplied, as in the file
    picture: Rgba  # the same through the lens
    depth_m: float | None  # None where the plate brings its coc
    coc_px: float  # signed diameter


class PictureReader:
    """Reads single pixels of a texture, again only when pixel or picture changed."""

    def __init__(self, ctx: moderngl.Context) -> None:
        self._ctx = ctx
        self._framebuffer: tuple[moderngl.Texture, moderngl.Framebuffer] | None = None
        self._last: tuple[object, Rgba] | None = None

    def pixel(self, shown: Shown, version: object, at: tuple[int, int]) -> Rgba:
        """Return the texel `at` (column, row) of the picture in float."""
        key = (version, shown.texture, at)
        if self._last is None or self._last[0] != key:
            box = (*at, 1, 1)
            data = self._bound(shown.texture).read(viewport=box, components=4, dtype="f4")
            red, green, blue, alpha = np.frombuffer(data, np.float32).tolist()
            self._last = (key, (red, green, blue, alpha))
        return self._last[1]

    def _bound(self, texture: moderngl.Texture) -> moderngl.Framebuffer:
        """Return a framebuffer around `texture`; release the old one after the new one is bound."""
        old = self._framebuffer
        if old is not None and old[0] is texture:
            return old[1]
        self._framebuffer = (texture, self._ctx.framebuffer([texture]))
        self._framebuffer[1].use()
        if old is not None:
            old[1].release()
        return self._framebuffer[1]


def probe_at(
    pixel: tuple[int, int],
    plate: Plate,
    lens: Lens,
    shown: Shown,
    version: object,
    reader: PictureReader,
) -> Probe | None:
    """Return the probe at a pixel of the display window; None outside the data window."""
    data, display = plate.data_window, plate.display_window
    at = pixel[0] + display.x0, pixel[1] + display.y0
    if not data.contains(*at):
        return None
    column, row = at[0] - data.x0, at[1] - data.y0
    here = Box(column, row, column + 1, row + 1)
    depth_m = plate.pixels.depth_in(here).item() if plate.has_distances else None
    width, height = shown.texture.size
    texel = column * width // data.width, row * height // data.height
    red, green, blue, alpha = plate.pixels.color_in(here)[0, 0].tolist()
    return Probe(
        pixel,
        at,
        (red, green, blue, alpha),
        reader.pixel(shown, version, texel),
        depth_m,
        _coc_at(plate, lens, row, column, depth_m),
    )


def seen_depth_m(plate: Plate, pixel: tuple[int, int]) -> float | None:
    """Return the distance at a pixel of the display window; None where there is none."""
    data, display = plate.data_window, plate.display_window
    at = pixel[0] + display.x0, pixel[1] + display.y0
    if not (plate.has_distances and data.contains(*at)):
        return None
    column, row = at[0] - data.x0, at[1] - data.y0
    return plate.pixels.depth_in(Box(column, row, column + 1, row + 1)).item()


def _coc_at(plate: Plate, lens: Lens, row: int, column: int, depth_m: float | None) -> float:
    if depth_m is None:
        assert plate.coc_px is not None
        return float(plate.coc_px[row, column])
    return float(coc_px(depth_m, coc_line(lens, plate.display_window.width)))


def probe_text(probe: Probe, unit: str) -> str:
    """Return one line for the status bar."""
    x, y = probe.display_px
    where = f"x {x}  y {y}"
    if probe.data_px != probe.display_px:
        where += f"  (data window {probe.data_px[0]}, {probe.data_px[1]})"
    depth = "" if probe.depth_m is None else f"   depth {_depth(probe.depth_m, unit)}"
    return (
        f"{where}   picture {_rgb(probe.picture)}   plate {_rgb(probe.plate)}"
        f"{depth}   coc {probe.coc_px:+.2f} px"
    )


def _depth(depth_m: float, unit: str) -> str:
    return "infinite" if math.isinf(depth_m) else format_distance(depth_m, unit)


def _rgb(value: Rgba) -> str:
    return " ".join(f"{channel:.4g}" for channel in value[:3])

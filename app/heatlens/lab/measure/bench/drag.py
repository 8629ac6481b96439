"""Measure the preview levels of a drag: pictures per second, and error to the picture at rest.

They are drawn as in the window at 1:1: enlarged, with the detail of the plate where it is in focus.
"""

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from heatlens.core.base.errors import InputError
from heatlens.core.model.boxes import Box
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.settings import DefocusSettings
from heatlens.core.model.shot.shot import Shot
from heatlens.lab.measure.bench import timing
from heatlens.lab.measure.bench.timing import BenchFrames, Frame, ReportProgress
from heatlens.lab.measure.metrics import flip_evaluation
from heatlens.media.plate.plate import Plate
from heatlens.render.defocus.kernels import Kernel
from heatlens.render.defocus.plate_passes import ProxyPass, RescalePass, proxy_size
from heatlens.render.defocus.quality import kernel_for
from heatlens.render.display.display_pass import DisplayPass
from heatlens.render.display.picture_pass import (
    CoarsePlate,
    DepthRangePass,
    Detail,
    EnlargePass,
    FocusMeanPass,
    PicturePass,
    PlacedPicture,
)
from heatlens.render.frame_renderer import FrameRenderer
from heatlens.render.gpu.resources import Sampling, Texture
from heatlens.render.gpu.textures import TexturePool
from heatlens.render.preview.level_choice import cheaper_levels

ScreenPixels = NDArray[np.float32]
_BLACK = np.zeros((16, 16, 3), np.float32)


@dataclass(eq=False)
class DragView:
    """Owns a screen as large as the picture at rest, in the plain sRGB curve."""

    renderer: FrameRenderer
    size: tuple[int, int]

    def __post_init__(self) -> None:
        ctx = self.renderer.ctx
        self._pool = TexturePool(ctx)
        self._display, self._enlarge = DisplayPass(ctx), EnlargePass(ctx)
        self._proxy, self._picture_pass = ProxyPass(ctx), PicturePass(ctx)
        self._focus_mean, self._rescale = FocusMeanPass(ctx), RescalePass(ctx)
        self._depth_range = DepthRangePass(ctx)
        self._out = ctx.texture(self.size, 4)
        self._screen = ctx.framebuffer([self._out])
        # Bound when the screen is released; the driver would bind the window's, which may not
        # exist.
        self._fallback = ctx.simple_framebuffer((1, 1))
        self._temporary: list[Texture] = []

    def draw_at_rest(self, picture: Texture) -> ScreenPixels:
        """Return the whole picture as on the screen, (H, W, 3), 0 to 1."""
        return self._draw_screen(self._to_display(picture), detail=None)

    def draw_moving(self, picture: Texture, shot: Shot, rest_proxy: float) -> ScreenPixels:
        """Return a level's `picture` of `shot` as it is shown while dragging."""
        proxy = shot.defocus.proxy
        if proxy >= rest_proxy:
            return self.draw_at_rest(picture)
        detail = self._detail(shot, rest_proxy, picture.size)
        return self._draw_screen(self._to_enlarged_display(picture), detail)

    def _detail(self, shot: Shot, rest_proxy: float, shown_size: tuple[int, int]) -> Detail:
        """Return the detail in focus that the preview of `shot`, of this size, lacks."""
        loaded, proxy = self.renderer.loaded, shot.defocus.proxy
        plate = self._to_display(
            self._reduce_plate(self.size) if rest_proxy < 1.0 else loaded.color
        )
        sides = (max(1, round(side * proxy / rest_proxy)) for side in self.size)
        width, height = sides
        line, mean = self.renderer.optics(shot).line, self._reduce_plate((width, height))
        depth_range = self._pool.texture("depths under a pixel", mean.size, 4)
        self._depth_range.run(loaded.depth, depth_range)
        focused = light = self._pool.texture("focused", mean.size, 4)
        diffused = self.renderer.light_without_highlights()
        coarse = CoarsePlate(mean, depth_range, diffused, loaded.light_scale)
        self._focus_mean.run(loaded.color, loaded.depth, line, coarse, focused)
        if shown_size != focused.size:
            light = self._pool.texture("enlarged", shown_size, 4)
            self._rescale.enlarge(focused, light)
        seen = self._to_enlarged_display(light)
        return Detail(plate, seen, focused, loaded.depth, line, 1.0 / proxy)

    def _reduce_plate(self, size: tuple[int, int]) -> Texture:
        """Return the loaded plate reduced to `size`, scene-linear."""
        loaded = self.renderer.loaded
        color = self._pool.texture(f"small plate {size}", size, 4)
        depth = self._pool.texture("small depth", size, 1)
        self._proxy.run(loaded.color, loaded.depth, 1.0, color, depth)
        return color

    def _new_texture(self, size: tuple[int, int]) -> Texture:
        """Return a texture that is released after the next screen has been drawn."""
        texture = self.renderer.ctx.texture(size, 4)
        texture.repeats = False
        self._temporary.append(texture)
        return texture

    def _to_display(self, picture: Texture) -> Texture:
        """Return the display values of a scene-linear picture."""
        out = self._new_texture(picture.size)
        self._display.run(picture, out)
        out.sampling = Sampling.NEAREST
        return out

    def _to_enlarged_display(self, picture: Texture) -> Texture:
        """Return display values that are sharpened for bilinear enlargement."""
        display = self._pool.texture("shown small", picture.size, 4, "f2")
        self._display.run(picture, display)
        out = self._new_texture(picture.size)
        self._enlarge.run(display, out)
        out.sampling = Sampling.LINEAR
        return out

    def _draw_screen(self, picture: Texture, detail: Detail | None) -> ScreenPixels:
        """Draw a picture over the whole screen, and return its pixels (H, W, 3), 0 to 1."""
        width, height = self.size
        placed_picture = PlacedPicture(
            picture,
            first=(0.0, 0.0),
            last=(float(width), float(height)),
            clip=Box(0, 0, width, height),
            is_nearest=detail is None,
            is_opaque=True,
            detail=detail,
        )
        self._picture_pass.run([placed_picture], self._screen, self.size)
        while self._temporary:
            self._temporary.pop().release()
        pixels = np.frombuffer(self._screen.read(components=3), np.uint8)
        return (pixels.reshape(height, width, 3)[::-1] / np.float32(255)).astype(np.float32)

    def release(self) -> None:
        """Delete all GPU objects except the framebuffer that stays bound."""
        self._fallback.use()
        self._screen.release()
        self._out.release()
        self._pool.release()
        self._display.release()


@dataclass(frozen=True, slots=True)
class DragRow:
    """One level of the ladder, the first being the picture at rest.

    ms and pictures_per_s  None where a picture took longer than the limit
    flip                   mean LDR-FLIP to the picture at rest, None where it was not measured
    """

    width: int
    height: int
    quality: str
    poles: int
    layer_count: int
    ms: float | None
    pictures_per_s: float | None
    flip: float | None


@dataclass(frozen=True, slots=True)
class DragReport:
    """All levels; `flip_missing` says why there is no FLIP, else it is ""."""

    source: str
    width: int
    height: int
    renderer: str
    rows: tuple[DragRow, ...]
    flip_missing: str


def level_message(settings: DefocusSettings, size: tuple[int, int]) -> str:
    """Return the progress message of a level; `size` is that of the plate."""
    width, height = proxy_size(size, settings.proxy)
    return f"level {width}x{height}, {settings.effective_quality}"


def measure_drag(
    frames: BenchFrames,
    plate: Plate,
    lens: Lens,
    settings: DefocusSettings,
    runs: int,
    report_progress: ReportProgress,
) -> DragReport:
    """Return time and FLIP of every level that the window may show of this picture."""
    missing_reason = missing_flip_reason()
    if missing_reason:
        report_progress(missing_reason)
    frame = frames.frame(plate, lens, settings)
    plate_size = frame.renderer.loaded.color.size
    size = proxy_size(plate_size, settings.proxy)
    view = DragView(frame.renderer, size)
    rest_pixels, rows = None, []
    for level in cheaper_levels(settings):
        report_progress(level_message(level, plate_size))
        row, pixels = _measure_level(
            frame, level, view, runs, None if missing_reason else rest_pixels
        )
        rest_pixels = pixels if rest_pixels is None else rest_pixels
        rows.append(row)
    view.release()
    renderer = frames.ctx.name
    return DragReport(str(plate.path), *size, renderer, tuple(rows), missing_reason)


def missing_flip_reason() -> str:
    """Return why FLIP cannot be measured here; "" if it can."""
    try:
        flip_evaluation(_BLACK, _BLACK, "LDR")
    except InputError as error:
        return f"FLIP is left out: {error}"
    return ""


def _measure_level(
    frame: Frame,
    level: DefocusSettings,
    view: DragView,
    runs: int,
    rest_pixels: ScreenPixels | None,
) -> tuple[DragRow, ScreenPixels | None]:
    """Measure one preview level and its picture; the picture is None if it took too long."""
    level_frame = replace(frame, shot=replace(frame.shot, defocus=level), enlarges=True)
    timed = timing.time_within_limit(level_frame, runs, timing.LIMIT_S)
    pixels = flip = None
    if timed is not None:
        pixels = view.draw_moving(timed.picture, level_frame.shot, frame.shot.defocus.proxy)
        flip = (
            None if rest_pixels is None else float(flip_evaluation(pixels, rest_pixels, "LDR")[1])
        )
    ms = None if timed is None else timed.ms
    kernel: Kernel = kernel_for(level)
    size = proxy_size(frame.renderer.loaded.color.size, level.proxy)
    rate = None if ms is None or not ms > 0.0 else 1e3 / ms
    row = DragRow(
        *size,
        str(level.effective_quality),
        len(kernel.poles),
        level_frame.layer_count,
        ms,
        rate,
        flip,
    )
    return row, pixels


def drag_table(report: DragReport) -> str:
    """Return the levels as a text table."""
    lines = [
        f"drag: {report.source}, {report.width}x{report.height} at rest; {report.renderer}",
        "level        pixels  quality   poles  layers        ms  pictures/s  FLIP to rest",
    ]
    for index, row in enumerate(report.rows):
        name = "at rest" if index == 0 else str(index)
        flip = "-" if row.flip is None else f"{row.flip:.4f}"
        lines.append(
            f"{name:8}{f'{row.width}x{row.height}':>11}  {row.quality:8}{row.poles:7d}"
            f"{row.layer_count:8d}{_cell(row.ms, 10)}{_cell(row.pictures_per_s, 12)}{flip:>14}"
        )
    if report.flip_missing:
        lines.append(report.flip_missing)
    return "\n".join(lines)


def _cell(value: float | None, width: int) -> str:
    """Return a number with one digit, or "too slow" if there is none."""
    return f"{'too slow' if value is None or math.isnan(value) else format(value, '.1f'):>{width}}"

"""Render the frames of an export one after the other, with guides as the window draws them."""

import time
from dataclasses import replace

import numpy as np

from heatlens.core.base.errors import InputError
from heatlens.core.model.shot.settings import Quality
from heatlens.core.model.view.guides import (
    LINE_OPACITY,
    NO_GUIDES,
    Canvas,
    Guides,
    Rect,
    frame_lines_for,
    guide_shapes,
)
from heatlens.deliver.export.burn_in import burn_in_text, draw_burn_in
from heatlens.deliver.export.frame_files import RenderedFrame, frame_timecode
from heatlens.deliver.export.job import DisplaySettings
from heatlens.deliver.export.pinhole_plate import pinhole_plate
from heatlens.deliver.export.plan import ExportPlan, PlannedFrame
from heatlens.deliver.export.sequence_check import Remark, SequenceCheck
from heatlens.media.plate.picture.picture_write import move_to_display_window
from heatlens.media.plate.plate import FloatImage, Plate
from heatlens.render.defocus.far_guess import FAR_PARTS
from heatlens.render.display.display_values import DisplayValues
from heatlens.render.frame_renderer import FrameRenderer
from heatlens.render.gpu.device import Device
from heatlens.render.gpu.resources import Texture
from heatlens.render.gpu.textures import download
from heatlens.render.source.source import Origin

_LINE_SHARE = 1 / 720  # thickness of a line as a part of the picture's height
_NOTABLE_SHARE = 0.1  # share of a frame's time above which a message says how much faster film is
_TIMED_FRAMES = (
    2  # frames whose parts of the lens are timed: in the first, drivers still build programs
)


class DisplayPictures:
    """Display pictures over black, all in the size of the display window.

    Players show the display window: overscan is cut off, and pixels outside the rendered area are
    black.
    """

    def __init__(self, ctx: Device, display_settings: DisplaySettings) -> None:
        self._values = DisplayValues(
            ctx, display_settings.transform, display_settings.exposure_stops, display_settings.gamma
        )
        self._black = self._values.encode(np.zeros((1, 1, 3), np.float32))[0, 0]

    def encode(self, picture: Texture, plate: Plate, proxy: float) -> FloatImage:
        """Return display values (H, W, 3) of `picture`, which is `plate` rendered at `proxy`."""
        return move_to_display_window(self._values.of(picture), plate, proxy, outside=self._black)

    def release(self) -> None:
        """Delete the objects on the GPU that convert to display values."""
        self._values.release()


class FrameRendering:
    """Renders `frames` of the plan, only on the thread that made it, which alone can draw."""

    def __init__(
        self, plan: ExportPlan, frames: tuple[PlannedFrame, ...], renderer: FrameRenderer
    ) -> None:
        self._job = plan.job
        self._renderer = renderer
        previous_origin = _origin_before(plan, frames[0])
        origins = (*filter(None, [previous_origin]), *(frame.origin for frame in frames))
        self._loader = plan.source.loader(
            plan.job.shot, origins, renderer, plan.job.pinhole_options.deep
        )
        self._sequence_check = SequenceCheck(plan.job.shot.plate_options.scene_unit_m)
        self._take_as_standard(previous_origin)
        is_final = self._job.shot.defocus.quality is Quality.FINAL and not self._job.pinhole
        timed_count = _TIMED_FRAMES if is_final else 0
        self._timed_frames = {frame.frame for frame in frames[:timed_count]}
        is_exr = plan.job.output.is_exr
        self._display_pictures = (
            None if is_exr else DisplayPictures(renderer.ctx, plan.job.display_settings)
        )

    def render(self, frame: PlannedFrame) -> RenderedFrame:
        """Render `frame`.

        Raises InputError if its plate is damaged or missing, or differs too much from the plates
        before it and the options are strict.
        """
        start_s, stopwatch = time.monotonic(), self._renderer.stopwatch
        self._loader.load(frame.origin)
        remarks = self._check_loaded_plate(frame.origin)
        if self._job.pinhole and self._job.output.is_exr and self._renderer.has_many_views:
            plate = self._make_pinhole_plate(frame)
            return RenderedFrame(planned=frame, plate=plate, pixels=plate.color, remarks=remarks)
        stopwatch.is_on = frame.frame in self._timed_frames
        rendered_frame = RenderedFrame(
            frame, self._loaded_plate(), self._render_pixels(frame), remarks
        )
        if not stopwatch.is_on:
            return rendered_frame
        stopwatch.is_on = False
        parts_s = stopwatch.times[FAR_PARTS].seconds if FAR_PARTS in stopwatch.times else 0.0
        return replace(rendered_frame, pace=pace_words(time.monotonic() - start_s, parts_s))

    def _take_as_standard(self, origin: Origin | None) -> None:
        """Take a plate as the standard with which the plates of later frames are compared."""
        if origin is None:
            return
        try:
            self._loader.load(origin)
        except InputError:  # that frame is not exported now: the first exported one decides
            return
        self._check_loaded_plate(origin, may_refuse=False)

    def _check_loaded_plate(self, origin: Origin, may_refuse: bool = True) -> tuple[Remark, ...]:
        """Return remarks on the loaded plate. Raises InputError if strict options refuse it."""
        if self._renderer.has_many_views or origin.is_black:
            return ()
        plate = self._renderer.loaded.plate
        remarks = self._sequence_check.check(plate)
        if remarks and may_refuse and self._job.shot.plate_options.strict:
            raise InputError(f"{plate.path}: {remarks[0].sentence}")
        return remarks

    def _make_pinhole_plate(self, frame: PlannedFrame) -> Plate:
        """Return a scene's picture without a lens, in memory for the thread that writes it."""
        shot, pinhole_options = self._job.shot, self._job.pinhole_options
        return pinhole_plate(
            self._renderer, shot, frame.frame, pinhole_options, frame.path
        ).in_memory()

    def close(self) -> None:
        """Stop reading, and delete the objects on the GPU."""
        self._loader.close()
        if self._display_pictures is not None:
            self._display_pictures.release()

    def _loaded_plate(self) -> Plate:
        """Return the plate, in memory if another thread will write its depth."""
        plate, options = self._renderer.loaded.plate, self._job.options
        return plate.in_memory() if options.with_depth or options.with_coc else plate

    def _render_pixels(self, frame: PlannedFrame) -> FloatImage:
        """Return the pixels of a frame for its file: light for EXR, else display values 0..1."""
        picture = self._render_picture(frame.frame)
        if self._display_pictures is None:
            return download(picture)
        plate, options = self._renderer.loaded.plate, self._job.options
        display = self._display_pictures.encode(picture, plate, self._job.shot.defocus.proxy)
        display = with_guides(display, self._job.display_settings.guides, plate.pixel_aspect_ratio)
        if not options.burn_in:
            return display
        timecode = frame_timecode(self._job, frame, plate)
        facts = frame.frame, frame.lens, plate, options.unit, timecode, options.shot_name
        return draw_burn_in(display, burn_in_text(options.burn_in_text, *facts))

    def _render_picture(self, frame: int) -> Texture:
        """Return the picture with the lens, or the pinhole picture if that is requested."""
        if self._job.pinhole:
            return self._renderer.loaded.color
        return self._renderer.render(self._job.shot, frame)


def pace_words(whole_s: float, parts_s: float) -> str:
    """Return a message on the time of a frame in the qualities "final" and "film".

    `parts_s` is the time that final takes to blur for parts of the lens opening, which film does
    not do.
    """
    is_notable = parts_s > _NOTABLE_SHARE * whole_s
    film_text = f"; --quality film takes about {_seconds_text(whole_s - parts_s)}"
    return f"about {_seconds_text(whole_s)} a frame{film_text if is_notable else ''}"


def _seconds_text(value: float) -> str:
    return f"{value:.0f} s" if value >= 10 else f"{value:.2g} s"


def _origin_before(plan: ExportPlan, first: PlannedFrame) -> Origin | None:
    """Return the origin of the plate before `first`, if that plate must be compared with it.

    That is so for a part of an export, which must give the same remarks as the whole export, and
    for strict options: exporting some frames of a shot, or resuming an export, must refuse the same
    frames. Otherwise returns None.
    """
    source, shot = plan.source, plan.job.shot
    if not (shot.plate_options.strict or plan.is_part) or source.first_file is None:
        return None
    earlier = [frame for frame in source.frames_of(shot) if frame < first.frame]
    try:
        return source.origin(shot, earlier[-1], "hold") if earlier else None
    except InputError:  # its depth or a file behind it is missing, but it is not exported now
        return None


def with_guides(display: FloatImage, guides: Guides, pixel_aspect: float) -> FloatImage:
    """Return `display`, (H, W, 3) in 0..1, with the guides drawn into it.

    `pixel_aspect` is the pixel aspect ratio of the file. A desqueeze widens the picture by its
    factor. Raises InputError if no canvas of the framing lines has the shape of the picture.
    """
    if guides == NO_GUIDES:
        return display
    lines = frame_lines_for(guides.canvases, display.shape[1], display.shape[0])
    if guides.canvases and not lines:
        raise InputError(_no_canvas_message(guides.canvases, display))
    if guides.desqueeze is not None:
        display, pixel_aspect = _stretch_width(display, guides.desqueeze), 1.0
    picture = display.copy()
    height, width = picture.shape[:2]
    shapes = guide_shapes(guides, (0.0, 0.0, width * pixel_aspect, float(height)), lines)
    for rect in shapes.shades:
        x0, y0, x1, y1 = (round(value) for value in _in_pixels(rect, pixel_aspect))
        picture[y0:y1, x0:x1] *= np.float32(1.0 - guides.opacity)
    drawn_lines = [
        *shapes.lines,
        *(side for frame in shapes.frames for side in _sides_of_rect(frame)),
    ]
    _draw_lines(picture, [_in_pixels(line, pixel_aspect) for line in drawn_lines], pixel_aspect)
    return picture


def _no_canvas_message(canvases: tuple[Canvas, ...], display: FloatImage) -> str:
    """Return the error for framing lines that fit no picture of this shape."""
    known = ", ".join(f"{it.width:g}x{it.height:g}" for it in canvases)
    return (
        f"The framing lines are for canvases of {known}, and none has the shape of a picture of "
        f"{display.shape[1]}x{display.shape[0]}: leave --framing out, or give another file."
    )


def _stretch_width(display: FloatImage, factor: float) -> FloatImage:
    """Return the picture `factor` times as wide; overshoot at edges is clipped."""
    from PIL import Image

    height, width = display.shape[:2]
    size = max(1, round(width * factor)), height
    planes = [
        np.asarray(Image.fromarray(display[..., i]).resize(size, Image.Resampling.LANCZOS))
        for i in range(3)
    ]
    stretched: FloatImage = np.clip(np.stack(planes, axis=-1), 0.0, 1.0, dtype=np.float32)
    return stretched


def _in_pixels(rect: Rect, pixel_aspect: float) -> Rect:
    """Return a rectangle or line with its x in pixels of the file instead of square pixels."""
    return rect[0] / pixel_aspect, rect[1], rect[2] / pixel_aspect, rect[3]


def _sides_of_rect(rect: Rect) -> tuple[Rect, ...]:
    """Return the four sides of a rectangle as lines: top, bottom, left, right."""
    x0, y0, x1, y1 = rect
    return (x0, y0, x1, y0), (x0, y1, x1, y1), (x0, y0, x0, y1), (x1, y0, x1, y1)


def _draw_lines(picture: FloatImage, lines: list[Rect], pixel_aspect: float) -> None:
    """Mix white into the pixels of all lines, once where two of them cross."""
    height, width = picture.shape[:2]
    thick = height * _LINE_SHARE
    mask = np.zeros((height, width), bool)
    for x0, y0, x1, y1 in lines:
        columns = _pixel_span(x0, x1, thick / pixel_aspect, width)
        mask[_pixel_span(y0, y1, thick, height), columns] = True
    picture[mask] += np.float32(LINE_OPACITY) * (1.0 - picture[mask])


def _pixel_span(first: float, last: float, thick: float, end: int) -> slice:
    """Return the pixels from `first` to `last`, at least one and within the picture."""
    count = max(1, round(max(last - first, thick)))
    start = round(first if last > first else first - count / 2)
    start = min(max(start, 0), end - 1)
    return slice(start, min(start + count, end))

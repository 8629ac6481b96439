"""The frames of an export one after the other: plates are read ahead while others are rendered."""

from dataclasses import replace
from functools import partial

import numpy as np

from heatlens.errors import InputError
from heatlens.export.burn_in import burn_in_text, burned_in
from heatlens.export.frame_files import RenderedFrame
from heatlens.export.plan import ExportPlan, PlannedFrame, plates_needed
from heatlens.export.shown import ShownPictures
from heatlens.gpu.textures import download
from heatlens.image.exr_read import read_plate
from heatlens.image.frame_cache import Damaged, FrameCache
from heatlens.image.plate import FloatImage, Plate
from heatlens.render import FrameRenderer

_AHEAD = 2  # plates read while one is rendered
# Six plates of 4K, four bytes for each of RGBA and depth; a larger one is read when it is its turn.
_PLATES_BYTES = 1 << 30


class FrameRendering:
    """Renders `frames` of the plan. Not for several threads: OpenGL is where it was made."""

    def __init__(
        self, plan: ExportPlan, frames: tuple[PlannedFrame, ...], renderer: FrameRenderer
    ) -> None:
        self._job = plan.job
        self._renderer = renderer
        self._loaded: tuple[Plate | None, bool] = (None, False)
        self._sequence = plates_needed(plan, frames)
        read = partial(read_plate, options=plan.job.shot.plate_options)
        self._cache = FrameCache(self._sequence, read, _PLATES_BYTES, keeps_seen=False)
        is_exr = plan.job.output.is_exr
        self._shown = None if is_exr else ShownPictures(renderer.ctx, plan.job.look)

    def rendered(self, frame: PlannedFrame) -> RenderedFrame:
        """The picture of `frame`; raises InputError where its plate is damaged or gone."""
        plate = self._plate_of(frame)
        if (plate, frame.is_black) != self._loaded:
            self._renderer.load(_black(plate) if frame.is_black else plate)
            self._loaded = (plate, frame.is_black)
        return RenderedFrame(frame, self._renderer.loaded.plate, self._pixels(frame))

    def close(self) -> None:
        """Stop reading; give what was used of OpenGL back."""
        self._cache.close()
        if self._shown is not None:
            self._shown.release()

    def _plate_of(self, frame: PlannedFrame) -> Plate:
        needed = self._sequence.frames
        left = len(needed) - 1 - needed.index(frame.plate_frame)
        # Players loop, and so does the cache: at the end it must not look further.
        plate = self._cache.wait(frame.plate_frame, window=min(_AHEAD, left))
        if isinstance(plate, Plate):
            return plate
        if isinstance(plate, Damaged):
            raise InputError(plate.sentence)
        raise InputError(f"{self._sequence.path_at(frame.plate_frame)} is not there any more.")

    def _pixels(self, frame: PlannedFrame) -> FloatImage:
        picture = self._renderer.render(self._job.shot, frame.frame)
        if self._shown is None:
            return download(picture)
        plate, look = self._renderer.loaded.plate, self._job.look
        display = self._shown.of(picture, plate, self._job.shot.defocus.proxy)
        if not look.burn_in:
            return display
        return burned_in(display, burn_in_text(frame.frame, frame.lens, plate, look.unit))


def _black(plate: Plate) -> Plate:
    """Nothing where `plate` is: no light, and no surface."""
    color = np.zeros_like(plate.color)
    if not plate.has_alpha:
        color[..., 3] = 1.0
    if plate.coc_px is not None:
        return replace(plate, color=color, coc_px=np.zeros_like(plate.coc_px))
    return replace(plate, color=color, depth_m=np.full(color.shape[:2], np.inf, np.float32))

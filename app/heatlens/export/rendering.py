"""Render the frames of an export one after the other."""

import moderngl

from heatlens.base.errors import InputError
from heatlens.export.burn_in import burn_in_text, burned_in
from heatlens.export.drawn_guides import with_guides
from heatlens.export.frame_files import RenderedFrame, frame_timecode
from heatlens.export.pinhole_plate import pinhole_plate
from heatlens.export.plan import ExportPlan, PlannedFrame
from heatlens.export.sequence_check import Remark, SequenceCheck
from heatlens.export.shown import ShownPictures
from heatlens.gpu.textures import download
from heatlens.plate.plate import FloatImage, Plate
from heatlens.render import FrameRenderer
from heatlens.source.origin import Origin


class FrameRendering:
    """Renders `frames` of the plan, only on the thread that made it, because of OpenGL."""

    def __init__(
        self, plan: ExportPlan, frames: tuple[PlannedFrame, ...], renderer: FrameRenderer
    ) -> None:
        self._job = plan.job
        self._renderer = renderer
        before = _origin_before(plan, frames[0])
        origins = (*filter(None, [before]), *(frame.origin for frame in frames))
        self._loader = plan.source.loader(plan.job.shot, origins, renderer, plan.job.beside.deep)
        self._check = SequenceCheck(plan.job.shot.plate_options.scene_unit_m)
        self._look_at(before)
        is_exr = plan.job.output.is_exr
        self._shown = None if is_exr else ShownPictures(renderer.ctx, plan.job.look)

    def rendered(self, frame: PlannedFrame) -> RenderedFrame:
        """Render `frame`.

        Raises InputError if its plate is damaged or missing, or does not go with the plates before
        it and the options are strict.
        """
        self._loader.load(frame.origin)
        remarks = self._remarks(frame.origin)
        if self._job.pinhole and self._job.output.is_exr and self._renderer.has_many_views:
            plate = self._pinhole(frame)
            return RenderedFrame(frame, plate, plate.color, remarks)
        return RenderedFrame(frame, self._plate(), self._pixels(frame), remarks)

    def _look_at(self, before: Origin | None) -> None:
        """Let the plate before the first frame decide what is usual."""
        if before is None:
            return
        try:
            self._loader.load(before)
        except InputError:  # that frame is not exported now, so the first one that is decides
            return
        self._remarks(before, may_refuse=False)

    def _remarks(self, origin: Origin, may_refuse: bool = True) -> tuple[Remark, ...]:
        """Return what is unusual about the loaded plate. Raises InputError if that is refused."""
        if self._renderer.has_many_views or origin.is_black:
            return ()
        plate = self._renderer.loaded.plate
        remarks = self._check.remarks(plate)
        if remarks and may_refuse and self._job.shot.plate_options.strict:
            raise InputError(f"{plate.path}: {remarks[0].sentence}")
        return remarks

    def _pinhole(self, frame: PlannedFrame) -> Plate:
        """Return a scene's picture without a lens, in memory for the thread that writes it."""
        shot, beside = self._job.shot, self._job.beside
        return pinhole_plate(self._renderer, shot, frame.frame, beside, frame.path).in_memory()

    def close(self) -> None:
        """Stop reading, and delete the objects of OpenGL."""
        self._loader.close()
        if self._shown is not None:
            self._shown.release()

    def _plate(self) -> Plate:
        """Return the plate, in memory if another thread will write its depth."""
        plate, wanted = self._renderer.loaded.plate, self._job.options
        return plate.in_memory() if wanted.with_depth or wanted.with_coc else plate

    def _pixels(self, frame: PlannedFrame) -> FloatImage:
        picture = self._picture(frame.frame)
        if self._shown is None:
            return download(picture)
        plate, options = self._renderer.loaded.plate, self._job.options
        display = self._shown.of(picture, plate, self._job.shot.defocus.proxy)
        display = with_guides(display, self._job.look.guides, plate.pixel_aspect_ratio)
        if not options.burn_in:
            return display
        told = frame_timecode(self._job, frame, plate)
        facts = frame.frame, frame.lens, plate, options.unit, told, options.shot_name
        return burned_in(display, burn_in_text(options.burn_in_text, *facts))

    def _picture(self, frame: int) -> moderngl.Texture:
        """Return the picture with the lens, or the pinhole picture if that is requested."""
        if self._job.pinhole:
            return self._renderer.loaded.color
        return self._renderer.render(self._job.shot, frame)


def _origin_before(plan: ExportPlan, first: PlannedFrame) -> Origin | None:
    """Return the plate before the first frame to render, if it has to be compared with.

    It is read for strict options alone: a part of a shot, or an export that goes on, must not take
    what a whole export would refuse.
    """
    source, shot = plan.source, plan.job.shot
    if not shot.plate_options.strict or source.first_file is None:
        return None
    earlier = [frame for frame in source.frames_of(shot) if frame < first.frame]
    try:
        return source.origin(shot, earlier[-1], "hold") if earlier else None
    except InputError:  # its depth or what lies behind it is missing, and it is not exported now
        return None

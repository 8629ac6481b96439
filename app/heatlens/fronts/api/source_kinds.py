"""The sources that `heatlens.open` returns: a plate in memory, plates of files, and a 3D scene."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from heatlens.core.base.errors import InputError
from heatlens.core.model.curves.frames import check_within
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.shot import LensCurves, Shot
from heatlens.fronts.api.engine import ENGINE
from heatlens.fronts.api.frame import FrameFacts, check_frame, facts_of
from heatlens.fronts.api.request import RenderRequest, lens_values
from heatlens.fronts.api.source import Source
from heatlens.media.plate.coc_line import focused_at_pixel
from heatlens.media.plate.plate import Plate
from heatlens.media.plate.plate_notes import breathing_notes, lens_notes, shot_notes
from heatlens.media.scene.first_shot import FirstShot
from heatlens.render.defocus.quality import unused_behind_notes
from heatlens.render.frame_renderer import FrameRenderer
from heatlens.render.source.plate_source import PlateSource


class OnePlate(Source):
    """A plate in memory, without frames; `is_strict` makes doubts errors."""

    def __init__(self, plate: Plate, is_strict: bool = False) -> None:
        super().__init__()
        self._plate = plate
        self._is_strict = is_strict

    @property
    def frames(self) -> tuple[int, ...]:
        return (1,)

    def _check_frame(self, frame: int) -> None:
        check_frame("An array", frame, self.frames)

    def _facts_at(self, frame: int) -> FrameFacts:
        return facts_of(self._plate)

    def _load_shot(self, renderer: FrameRenderer, request: RenderRequest) -> tuple[Shot, int]:
        """Upload the plate; return a shot with the requested lens, and frame 0."""
        if request.frame is not None:
            self._check_frame(request.frame)
        lens = request.lens(self._plate)
        doubts = lens_notes(self._plate, lens, 1.0, self._is_strict)
        self._note_plate(self._plate, request, doubts)
        ENGINE.load(self, self._plate, renderer.load)
        return _with_blur(Shot(lens), request), 0


class Plates(Source):
    """A sequence of files; `shot` has the lens if a shot file was opened."""

    def __init__(self, source: PlateSource, shot: Shot | None) -> None:
        super().__init__()
        self._source = source
        self._sequence = source.sequence
        self._shot = shot
        self._last_plate: tuple[Path, Plate] | None = None

    def _load_shot(self, renderer: FrameRenderer, request: RenderRequest) -> tuple[Shot, int]:
        """Upload the plate of the requested frame; return the shot and that frame."""
        shot_frame = self._frame_to_render(request.frame)
        plate = self._read_plate(self._sequence.path_at(shot_frame))
        shot, doubts = self._shot_with_lens(plate, shot_frame, request)
        self._note_plate(plate, request, (*doubts, *unused_behind_notes(plate, shot.defocus)))
        ENGINE.load(self, plate, renderer.load)
        return shot, shot_frame

    def close(self) -> None:
        self._last_plate = None
        super().close()

    @property
    def frames(self) -> tuple[int, ...]:
        """See `Source.frames`; only frames with a file count."""
        frames = self._sequence.frames
        if self._shot is not None:
            frames = self._source.frames_of(self._shot)
        is_still = not self._sequence.form.padding
        return tuple(frame for frame in frames if is_still or self._sequence.has_file(frame))

    def _check_frame(self, frame: int) -> None:
        """Raise InputError for a frame that the sequence does not have."""
        form = self._sequence.form
        is_one = self._shot is None and self._source.frames is None
        sequence_name = form.text if is_one and form.padding else ""
        check_frame(self._source.text, frame, self.frames, sequence_name)

    def _facts_at(self, frame: int) -> FrameFacts:
        shot_values = None if self._shot is None else lens_values(self._shot.lens_at(frame))
        return facts_of(self._read_plate(self._sequence.path_at(frame)), shot_values)

    def _frame_to_render(self, frame: int | None) -> int:
        """Return the frame to render. Raises InputError for one that the plates do not have."""
        if frame is None:
            return self._sequence.present[0]
        if self._shot is None:
            self._check_frame(frame)
        return frame

    def _shot_with_lens(
        self, plate: Plate, frame: int, request: RenderRequest
    ) -> tuple[Shot, tuple[str, ...]]:
        """Return the shot with the lens of a request, and doubts about it."""
        options, shot = self._source.options, self._shot
        shot_values = {} if shot is None else lens_values(shot.lens_at(frame))
        lens = request.lens(plate, shot_values)
        if shot is None or request.changes_lens:
            doubts = lens_notes(plate, lens, options.scene_unit_m, options.strict)
        else:
            doubts = shot_notes(shot, plate)
        return _with_blur(Shot(lens) if shot is None else _with_lens(shot, lens), request), doubts

    def _read_plate(self, path: Path) -> Plate:
        """Return a plate; the last one stays in memory, as the lens changes more often than it."""
        if self._last_plate is None or self._last_plate[0] != path:
            self._last_plate = (path, self._source.read(path))
        return self._last_plate[1]


class Scene(Source):
    """A 3D scene, through one of its cameras."""

    def __init__(self, first: FirstShot, text: str) -> None:
        super().__init__()
        self._first = first
        self._text = text

    @property
    def frames(self) -> tuple[int, ...]:
        return tuple(self._first.shot.frames or (self._first.frame,))

    @property
    def cameras(self) -> tuple[str, ...]:
        return tuple(camera.name for camera in self._first.scene.cameras)

    def _check_frame(self, frame: int) -> None:
        check_within(self._first.shot.frames, self._text, (frame,))

    def _facts_at(self, frame: int) -> FrameFacts:
        """Return the facts of a frame, for which the scene is drawn."""
        lens_at_frame = lens_values(self._first.shot.lens_at(frame)).items()
        lens = {name: value for name, value in lens_at_frame if name not in self._first.assumed}
        shot, renderer = self._first.shot, ENGINE.renderer()
        ENGINE.load(self, self._first.scene, renderer.load_scene)
        return facts_of(renderer.load_pinhole(shot, frame).plate, lens)

    def _load_shot(self, renderer: FrameRenderer, request: RenderRequest) -> tuple[Shot, int]:
        """Upload the scene; return the shot of the request and its frame."""
        first = self._first
        frame = first.frame if request.frame is None else request.frame
        self._check_frame(frame)
        self._check_lens(request)
        ENGINE.load(self, first.scene, renderer.load_scene)
        shot = _with_values(_with_blur(first.shot, request), frame, request.lens_fields)
        if request.focus_at is not None:
            plate = renderer.load_pinhole(shot, frame).plate
            shot = _with_lens(shot, focused_at_pixel(plate, shot.lens_at(frame), *request.focus_at))
        self._notes.warn(*first.scene.notes, *breathing_notes(shot.lens_at(frame), plate=None))
        return shot, frame

    def _check_lens(self, request: RenderRequest) -> None:
        """Raise InputError if a value that blur depends on is not known."""
        given_names = {
            *request.lens_fields,
            *([] if request.focus_at is None else ["focus_distance_m"]),
        }
        needed = {"f_stop", "focus_distance_m"} & self._first.assumed - given_names
        if needed:
            missing = " and ".join(sorted(needed))
            raise InputError(
                f"{self._text}: the scene does not define the whole lens: give {missing}."
            )


def _with_blur(shot: Shot, request: RenderRequest) -> Shot:
    """Return the shot with the blur of a request."""
    return replace(shot, defocus=replace(shot.defocus, **request.blur_fields))


def _with_values(shot: Shot, frame: int, lens_fields: Mapping[str, Any]) -> Shot:
    """Return the shot at one frame, its lens there changed by the given values."""
    if not lens_fields:
        return shot
    return _with_lens(shot, replace(shot.lens_at(frame), **lens_fields))


def _with_lens(shot: Shot, lens: Lens) -> Shot:
    """Return the shot with a lens that does not change over time."""
    return replace(shot, lens=lens, curves=LensCurves())

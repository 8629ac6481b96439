"""Read the frames of a sequence, and add the hidden surfaces that neighboring frames show."""

import threading
from collections.abc import Callable
from concurrent.futures import Future
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from heatlens.core.base.byte_lru import ByteLru
from heatlens.core.base.errors import InputError
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.media.frame_cache.plate_shelf import plate_bytes
from heatlens.media.frame_cache.sequence_reader import SequenceReader
from heatlens.media.plate.header.placement import convert_from_exr, find_placement, is_rigid
from heatlens.media.plate.neighbours.trust import (
    border_px,
    choose_frame_step,
    choose_frames,
    is_static_between,
)
from heatlens.media.plate.neighbours.view import FloatMatrix, View
from heatlens.media.plate.parts.header_read import read_headers
from heatlens.media.plate.plate import Plate
from heatlens.media.sequence.sequence import Sequence, Stamp, stamp_of

if TYPE_CHECKING:  # most sequences use no neighbors
    from heatlens.media.plate.neighbours.found import NeighbourResult

DEFAULT_COUNT = 2  # frames on either side where the headers tell the camera
_SHELF_BYTES = 1 << 30  # six plates of 4K
_Key = tuple[Path, Stamp | None]
_NOT_USED = "No neighbouring frames are used."


@dataclass(frozen=True)
class Neighbourhood:
    """The frames that show hidden surfaces of each other.

    count    frames on either side; 0 where none are used
    step     distance between two of them, in frames
    cameras  world-to-camera matrices by frame; empty for a camera that stands still
    words    a sentence: which frames are used, or why none are
    """

    count: int = 0
    step: int = 1
    cameras: dict[int, FloatMatrix] = field(default_factory=dict)
    words: str = _NOT_USED

    def neighbours_of(self, frame: int, present: tuple[int, ...]) -> tuple[int, ...]:
        """Return the neighbors of `frame` that are used."""
        candidates = self.cameras or present
        if not self.count or frame not in candidates:
            return ()
        return choose_frames(frame, tuple(candidates), self.count, self.step)


class NeighbourReader:
    """Reads plates as a `SequenceReader` does, and adds surfaces that only other frames show.

    The frames are chosen from the whole sequence, so that parts of an export equal the whole. May
    be called from several threads; each plate is read once as long as it fits into memory.
    """

    def __init__(self, options: PlateOptions, sequence: Sequence) -> None:
        self._options = options
        self._sequence = sequence
        self._read = SequenceReader(options, sequence.path_at(sequence.present[0]))
        self._plate_cache = _PlateCache(self._read)
        self._lock = threading.Lock()

    def __call__(self, path: Path) -> Plate:
        """Read the plate at `path` and add the surfaces. Raises InputError as `read_plate` does."""
        plate = self.read_alone(path)
        return self.add_hidden_surfaces(plate).plate if self.neighbourhood.count else plate

    def read_alone(self, path: Path) -> Plate:
        """Read the plate at `path` without its neighbors."""
        return self._plate_cache(path) if self.neighbourhood.count else self._read(path)

    def add_hidden_surfaces(self, plate: Plate) -> "NeighbourResult":
        """Add hidden surfaces to a plate that was read alone, and report which frames showed them.

        A neighbor that cannot be read is named and left out.
        """
        from heatlens.media.plate.neighbours.found import NeighbourResult, with_neighbours

        path, frames = plate.path, self._neighbour_frames(plate.path)
        view = None if not frames else self._view(self._frame_number(path), plate)
        if view is None:
            return NeighbourResult(plate, hidden_part=0.0, frames=())
        views, unreadable_frames = [], []
        for frame in frames:
            try:
                views.append(self._view(frame, self._plate_cache(self._sequence.path_at(frame))))
            except InputError as error:
                unreadable_frames.append((frame, str(error)))
        neighbour_views = [neighbour_view for neighbour_view in views if neighbour_view is not None]
        result = with_neighbours(view, neighbour_views, border_px(plate))
        left_out = tuple(sorted((*result.left_out, *unreadable_frames)))
        notes = tuple(f"Frame {it} is not used for {path}: {reason}" for it, reason in left_out)
        with_notes = replace(result.plate, notes=(*result.plate.notes, *notes))
        return replace(result, plate=with_notes.count_bins(), left_out=left_out)

    def files_of(self, path: Path) -> tuple[Path, ...]:
        """Return the files of the neighbors that the plate at `path` is made with."""
        return tuple(self._sequence.path_at(frame) for frame in self._neighbour_frames(path))

    @property
    def neighbourhood(self) -> Neighbourhood:
        """The frames used; the first call reads headers and a plate or two."""
        with self._lock:
            return self._neighbourhood

    @cached_property
    def _neighbourhood(self) -> Neighbourhood:
        """The neighbors to use; the options, the headers and a plate or two decide."""
        requested_count, present = self._options.neighbours, self._sequence.present
        if requested_count == 0 or len(present) < 2 or not self._sequence.form.padding:
            return Neighbourhood()
        cameras = self._cameras()
        plate = self._first_readable(present) if cameras or requested_count else None
        if plate is None or (requested_count is None and plate.fragments is not None):
            return Neighbourhood()  # not requested, or the plate holds its hidden surfaces
        if obstacle := self._obstacle(plate, cameras):
            return Neighbourhood(words=f"{_NOT_USED} {obstacle}")
        return self._choose_neighbours(plate, requested_count or DEFAULT_COUNT, cameras)

    def _choose_neighbours(
        self, plate: Plate, count: int, cameras: dict[int, FloatMatrix]
    ) -> Neighbourhood:
        """Return the frames on either side that are used; all plates are like `plate`."""
        focal = _focal_px(plate, self._options) or (1.0, 1.0)
        step = choose_frame_step(cameras, plate, focal[0], count)
        step_words = "" if step == 1 else f", every {step} frames"
        reason = "the headers have the camera" if cameras else "the camera stands still"
        words = f"Uses {count} frames on either side{step_words}: {reason}."
        return Neighbourhood(count, step, cameras, words)

    def _obstacle(self, plate: Plate, cameras: dict[int, FloatMatrix]) -> str:
        """Return a sentence on why no neighbors can be used; "" if they can."""
        if not plate.has_distances:
            return "The plates hold circles of confusion."
        if cameras:
            return "" if _focal_px(plate, self._options) else _NO_FOCAL
        last_plate = self._first_readable(self._sequence.present[::-1])
        return "" if last_plate is not None and is_static_between(plate, last_plate) else _NO_CAMERA

    def _first_readable(self, frames: tuple[int, ...]) -> Plate | None:
        """Return the plate of the first of `frames` that can be read; None if none can."""
        for frame in frames:
            try:
                return self._plate_cache(self._sequence.path_at(frame))
            except InputError:  # reported where the frame is shown
                continue
        return None

    def _cameras(self) -> dict[int, FloatMatrix]:
        """Return the matrix from world to camera by frame; {} if any header lacks it."""
        cameras = {}
        for frame in self._sequence.present:
            try:
                attribute = find_placement(read_headers(self._sequence.path_at(frame)))
            except InputError:  # reported where the frame is shown; the others are used
                continue
            if attribute is None:
                return {}
            matrix, _ = convert_from_exr(attribute, self._options.scene_unit_m)
            if not is_rigid(matrix):
                return {}
            cameras[frame] = matrix
        return cameras

    def _frame_number(self, path: Path) -> int:
        """Return the frame of the sequence whose file is `path`; there must be one."""
        frame = self._sequence.frame_at(path)
        assert frame is not None  # `_neighbour_frames` found neighbors
        return frame

    def _neighbour_frames(self, path: Path) -> tuple[int, ...]:
        """Return the neighbors that are used for the plate at `path`."""
        frame, present = self._sequence.frame_at(path), self._sequence.present
        return () if frame is None else self.neighbourhood.neighbours_of(frame, present)

    def _view(self, frame: int, plate: Plate) -> View | None:
        """Return a plate with its camera; None if its focal length is unknown."""
        cameras, box = self.neighbourhood.cameras, plate.display_window
        centre = box.width / 2, box.height / 2
        if not cameras:
            return View(frame, plate, np.eye(4), (float(box.width),) * 2, centre)
        focal = _focal_px(plate, self._options)
        return None if focal is None else View(frame, plate, cameras[frame], focal, centre)


_NO_FOCAL = "The focal length of the camera is unknown: give --focal-length and a film back."
_NO_CAMERA = (
    "The camera moves, and the headers do not have its position: render the plates with the entry "
    "worldToCamera."
)


def _focal_px(plate: Plate, options: PlateOptions) -> tuple[float, float] | None:
    """Return the focal length in pixels along x and y; None if it is not known."""
    length_mm = plate.camera.focal_length_mm or options.focal_length_mm
    width_mm = plate.camera.sensor_width_mm or options.sensor_width_mm
    if length_mm is None or width_mm is None:
        return None
    focal_px = length_mm / width_mm * plate.display_window.width
    return focal_px, focal_px * plate.pixel_aspect_ratio


class _PlateCache:
    """Keeps the latest plates within a limit of bytes, so that each is read once."""

    def __init__(self, read: Callable[[Path], Plate]) -> None:
        self._read = read
        self._lock = threading.Lock()
        # The newest plate is kept even if it alone exceeds the limit: it may be on the screen.
        self.plates: ByteLru[_Key, Plate] = ByteLru(_SHELF_BYTES, plate_bytes, keeps_newest=True)
        self._pending_reads: dict[_Key, Future[Plate]] = {}

    def __call__(self, path: Path) -> Plate:
        """Return the plate at `path`; read it if it is not cached or its file has changed."""
        key = path, stamp_of(path)
        with self._lock:
            plate = self.plates.get(key)
            if plate is not None:
                return plate
            is_first_request = key not in self._pending_reads
            pending = self._pending_reads.setdefault(key, Future())
        if is_first_request:
            self._complete_read(key, pending)
        return pending.result()

    def _complete_read(self, key: _Key, pending: "Future[Plate]") -> None:
        """Read a plate, put it or its error into `pending`, and cache the plate."""
        try:
            pending.set_result(self._read(key[0]))
        except BaseException as error:
            pending.set_exception(error)
        with self._lock:
            del self._pending_reads[key]
            if pending.exception() is None:
                self.plates.put(key, pending.result())

"""Plates as a source: a single file, or the files of a numbered sequence.

Numbered files are a sequence only if their pictures have the same size: hero.0720.exr and
hero.1080.exr may be two sizes of the same picture. The names alone cannot decide, so the headers of
a few neighbors are read, in about a tenth of a millisecond each.
"""

import os
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from heatlens.core.base.errors import InputError
from heatlens.core.base.paths import absolute
from heatlens.core.model.curves.frames import FrameRange
from heatlens.core.model.focus.live_focus import Distances
from heatlens.core.model.marks.mark import Mark
from heatlens.core.model.marks.track_mark import TrackMark
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.core.model.shot.shot import Shot
from heatlens.media.files.picture_formats import is_picture
from heatlens.media.frame_cache.cache import Damaged, FrameCache
from heatlens.media.frame_cache.sequence_reader import SequenceReader
from heatlens.media.plate.parts.header_read import read_headers
from heatlens.media.plate.plate import Plate, ReadPixels
from heatlens.media.sequence.depth_files import PlateFiles, behind_paths, depth_path_for
from heatlens.media.sequence.names import NameForm, frames_text
from heatlens.media.sequence.sequence import MissingPolicy, Sequence, stamp_files
from heatlens.media.sequence.sequence_search import find_sequence
from heatlens.render.source.source import FrameLoader, Origin, Renderer

if TYPE_CHECKING:  # a source is often named and not read
    from heatlens.media.frame_cache.neighbour_reader import NeighbourReader

_STILL_FRAME = 1  # the frame number of a picture without a number in its name
_AHEAD = 2  # plates that are read while one is rendered
# Six plates of 4K with float32 RGBA and depth; a larger plate is read only when it is needed.
_PLATES_BYTES = 1 << 30


@dataclass(frozen=True)
class PlateSource:
    """The files of a sequence, read with `options`. Implements `Source`."""

    text: str
    sequence: Sequence
    options: PlateOptions

    has_many_views: ClassVar = False

    @property
    def files(self) -> Path:
        return Path(self.sequence.pattern)

    @cached_property
    def read(self) -> "NeighbourReader":
        """A function that reads a plate with the surfaces and border that its neighbors show."""
        from heatlens.media.frame_cache.neighbour_reader import NeighbourReader

        return NeighbourReader(self.options, self.sequence)

    @cached_property
    def own_files(self) -> PlateFiles:
        """A function that lists the files of the plate at a path alone, its own file first."""
        return PlateFiles(self.options.files_beside)

    def files_of(self, path: Path) -> tuple[Path, ...]:
        """Return the files of the plate at a path, its own file first; then its neighbors'."""
        neighbours = self.read.files_of(path)
        return (
            *self.own_files(path),
            *(file for neighbour in neighbours for file in self.own_files(neighbour)),
        )

    @property
    def all_files(self) -> tuple[Path, ...]:
        """See `Source`; neighbors are chosen from all plates."""
        neighbours = self.sequence.present if self.read.neighbourhood.count else ()
        paths = (self.first_file, *map(self.sequence.path_at, neighbours))
        return tuple(dict.fromkeys(file for path in paths for file in self.own_files(path)))

    @property
    def frames(self) -> FrameRange | None:
        sequence = self.sequence
        return None if sequence.is_single else FrameRange(sequence.first, sequence.last)

    @property
    def first_file(self) -> Path:
        return self.sequence.path_at(self.sequence.present[0])

    def with_absolute_paths(self) -> "PlateSource":
        sequence = replace(self.sequence, folder=Path(absolute(self.sequence.folder)))
        options = self.options.with_files_beside(absolute)
        return PlateSource(absolute(self.text), sequence, options)

    def require(self) -> None:
        """See `Source`; a sequence that was found has files."""

    def span(self, shot: Shot) -> FrameRange | None:
        """See `Source`; `check` reports missing frames, which others may replace."""
        return None

    def frames_of(self, shot: Shot) -> tuple[int, ...]:
        """See `Source`; if the pattern names frames, only these are used."""
        if shot.played_frames is None:
            return self.sequence.frames
        if self.sequence.frame_range is None:
            return tuple(shot.played_frames)
        return tuple(frame for frame in self.sequence.frames if frame in shot.played_frames)

    def check(self, shot: Shot, frames: tuple[int, ...], missing: MissingPolicy) -> None:
        """Raise InputError for frames without a file, if such frames stop the export."""
        if missing != "stop" or self._is_still(shot):
            return
        gaps = [frame for frame in frames if not self.sequence.has_file(frame)]
        if gaps:
            raise InputError(
                f"{self.sequence.pattern} has no file for {len(gaps)} of {len(frames)} frames: "
                f"{frames_text(gaps)}. --missing hold replaces them by the previous frame, "
                "--missing black by a black picture."
            )

    def origin(self, shot: Shot, frame: int, missing: MissingPolicy) -> Origin:
        """See `Source`; a missing frame is made of the plate that replaces it."""
        if self._is_still(shot):
            return self._origin(self.sequence.first, is_black=False)
        shown_frame = self.sequence.shown_frame(frame, "hold")
        assert shown_frame is not None  # a sequence that was found has a file
        return self._origin(shown_frame, is_black=missing == "black" and shown_frame != frame)

    def loader(
        self, shot: Shot, origins: tuple[Origin, ...], renderer: Renderer, is_for_file: bool = False
    ) -> FrameLoader:
        """See `Source`; the next plates are read while a frame is rendered."""
        needed_frames = tuple(sorted({origin.frame for origin in origins}))
        needed_sequence = replace(self.sequence, frames=needed_frames, present=needed_frames)
        return _PlateLoader(needed_sequence, self.read, renderer)

    def distances_m(
        self, shot: Shot, mark: Mark, report_progress: Callable[[str], None]
    ) -> Distances:
        """See `Source`; a missing frame is that of the plate before it."""
        from heatlens.media.plate.mark_distance import mark_distances_m

        sequence, options = self.sequence, replace(self.options, never_blur=None, only_blur=None)
        frames = shot.frames or FrameRange(sequence.first, sequence.last)
        if isinstance(mark, TrackMark):
            return {frame: mark.distance_at_m(frame) for frame in frames}
        read = SequenceReader(options, self.first_file)

        def plates() -> Iterator[tuple[int, Plate]]:
            """Yield each frame with its plate; a missing one is replaced by the previous."""
            for frame in frames:
                report_progress(f"measuring {mark.name} at frame {frame} of {frames}")
                shown_frame = sequence.shown_frame(frame, "hold")
                assert shown_frame is not None  # a sequence that was found has a file
                yield frame, read(sequence.path_at(shown_frame))

        return mark_distances_m(plates(), mark)

    def _is_still(self, shot: Shot) -> bool:
        """Return True for a single file that is shown at every frame."""
        sequence = self.sequence
        return not sequence.form.padding or (sequence.is_single and shot.frames is None)

    def _origin(self, frame: int, is_black: bool) -> Origin:
        """Return the origin of an existing frame. Raises InputError if a file of it is missing."""
        path, depth = self.sequence.path_at(frame), self.options.depth_source
        if depth is not None:
            depth_path_for(path, depth)  # raises InputError where the frame has no depth
        behind_paths(path, self.options)  # raises InputError likewise
        return Origin(frame, is_black, stamp_files(self.files_of(path)))


class _PlateLoader:
    """Loads plates into a renderer, and reads the next ones ahead. See `FrameLoader`."""

    def __init__(self, sequence: Sequence, read: "NeighbourReader", renderer: Renderer) -> None:
        self._renderer = renderer
        self._loaded: tuple[Plate | None, bool] = (None, False)
        self._sequence = sequence
        self._cache = FrameCache(sequence, read, _PLATES_BYTES, keeps_passed=False)

    def load(self, origin: Origin) -> None:
        """Upload the plate of an origin, or black, unless it is there already."""
        plate, is_black = self._plate_at(origin.frame), origin.is_black
        if (plate, is_black) != self._loaded:
            self._renderer.load(black_plate(plate) if is_black else plate)
            self._loaded = (plate, is_black)

    def close(self) -> None:
        self._cache.close()

    def _plate_at(self, frame: int) -> Plate:
        """Return the plate of a frame. Raises InputError if it is damaged or gone."""
        needed_frames = self._sequence.frames
        frames_left = len(needed_frames) - 1 - needed_frames.index(frame)
        # After the last frame the cache would continue with the first, as players do: prevent it.
        plate = self._cache.read_and_wait(frame, window=min(_AHEAD, frames_left))
        if isinstance(plate, Plate):
            return plate
        if isinstance(plate, Damaged):
            raise plate.error
        raise InputError(f"{self._sequence.path_at(frame)} has disappeared.")


def black_plate(plate: Plate) -> Plate:
    """Return a plate of the same size without any light, and without surfaces at any depth."""
    plate = replace(plate, fragments=None, behind=(), with_border=None, cutout=None)
    color = np.zeros_like(plate.color)
    if not plate.has_alpha:
        color[..., 3] = 1.0
    if plate.coc_px is not None:
        return replace(plate, pixels=ReadPixels(color, coc_px=np.zeros_like(plate.coc_px)))
    nowhere_m = np.full(color.shape[:2], np.inf, np.float32)
    return replace(plate, pixels=ReadPixels(color, nowhere_m))


def make_single_plate_source(path: Path, options: PlateOptions) -> PlateSource:
    """Return the plate in one file, even if it is a frame of a sequence; the disk is not read."""
    sequence = Sequence(path.parent, NameForm(path.name, 0, ""), (_STILL_FRAME,), (_STILL_FRAME,))
    return PlateSource(str(path), sequence, options)


Size = tuple[int, int]


def sequence_of_one_size(text: str) -> Sequence:
    """Find the sequence for `text`; a file whose neighbors have another size stands alone.

    A pattern or a folder means all of its files. Raises InputError as `find_sequence` does.
    """
    sequence = find_sequence(text)
    path = Path(os.path.expanduser(text))
    if sequence.is_single or sequence.folder == path or not os.path.isfile(path):
        return sequence
    named_frame = sequence.frame_at(path)
    own_size = _size_of(path)
    neighbour_sizes = (
        _size_of(sequence.path_at(frame)) for frame in _neighbours(sequence, named_frame)
    )
    if own_size is None or all(size in (None, own_size) for size in neighbour_sizes):
        return sequence
    return find_sequence(text, whole=False)


def _neighbours(sequence: Sequence, frame: int | None) -> set[int]:
    """Return the first and last present frame, and the present ones next to `frame`."""
    present = sequence.present
    index = present.index(frame) if frame in present else 0
    return {
        present[0],
        present[-1],
        present[max(index - 1, 0)],
        present[min(index + 1, len(present) - 1)],
    }


def _size_of(path: Path) -> Size | None:
    """Return width and height of the display window; None if the header cannot be read."""
    try:
        if is_picture(path):
            from heatlens.media.plate.picture.picture_open import picture_info

            return picture_info(path)[0]
        (x0, y0), (x1, y1) = read_headers(path)[0]["displayWindow"]
    except (InputError, KeyError):  # reported when the file is opened
        return None
    return int(x1 - x0) + 1, int(y1 - y0) + 1

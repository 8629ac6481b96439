"""Plates as what an export is made of: read ahead while others are rendered."""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from heatlens.errors import InputError
from heatlens.export.frame_source import FrameLoader, Origin, PlannedFrame
from heatlens.frame_cache.cache import Damaged, FrameCache
from heatlens.frame_cache.reader import SequenceReader
from heatlens.model.shot import Shot
from heatlens.plate.plate import Plate, ReadPixels
from heatlens.render import FrameRenderer
from heatlens.sequence.depth_files import depth_path_for
from heatlens.sequence.names import frames_text
from heatlens.sequence.sequence import MissingPolicy, Sequence, stamp_of

_AHEAD = 2  # plates read while one is rendered
# Six plates of 4K, four bytes for each of RGBA and depth; a larger one is read when it is its turn.
_PLATES_BYTES = 1 << 30


@dataclass(frozen=True)
class PlateFrames:
    """The files of a numbered picture, or of one that is there at every frame."""

    sequence: Sequence

    @property
    def files(self) -> Path:
        """The pattern."""
        return Path(self.sequence.pattern)

    @property
    def beside(self) -> tuple[Path, ...]:
        """A plate names no other file."""
        return ()

    def frames_of(self, shot: Shot) -> tuple[int, ...]:
        """Those from in to out; of frames that a pattern names, only these."""
        if shot.played is None:
            return self.sequence.frames
        if self.sequence.frame_range is None:
            return tuple(shot.played)
        return tuple(frame for frame in self.sequence.frames if frame in shot.played)

    def check(self, shot: Shot, frames: tuple[int, ...], missing: MissingPolicy) -> None:
        """InputError naming the frames that have no file, where none stands in."""
        if missing != "stop" or self._is_still(shot):
            return
        gaps = [frame for frame in frames if not self.sequence.has(frame)]
        if gaps:
            raise InputError(
                f"{self.sequence.pattern} has no file for {len(gaps)} of {len(frames)} frames: "
                f"{frames_text(gaps)}. --missing hold puts the frame before in their place, "
                "--missing black a black picture."
            )

    def origin(self, shot: Shot, frame: int, missing: MissingPolicy) -> Origin:
        """The plate of `frame`, or the one that stands in for it."""
        if self._is_still(shot):
            return self._read_from(shot, self.sequence.first, is_black=False)
        held = self.sequence.shown_frame(frame, "hold")
        assert held is not None  # a sequence that was found has a file
        return self._read_from(shot, held, is_black=missing == "black" and held != frame)

    def loader(
        self, shot: Shot, frames: tuple[PlannedFrame, ...], renderer: FrameRenderer
    ) -> FrameLoader:
        """Reads the plates of `frames` alone."""
        needed = tuple(sorted({frame.origin.frame for frame in frames}))
        sequence = replace(self.sequence, frames=needed, present=needed)
        first = self.sequence.path_at(self.sequence.present[0])
        return _PlateLoader(sequence, shot, renderer, first)

    def _is_still(self, shot: Shot) -> bool:
        """One file, which is there at every frame."""
        sequence = self.sequence
        return not sequence.form.padding or (sequence.is_single and shot.frames is None)

    def _read_from(self, shot: Shot, frame: int, is_black: bool) -> Origin:
        path, depth_source = self.sequence.path_at(frame), shot.plate_options.depth_source
        beside = () if depth_source is None else (stamp_of(depth_path_for(path, depth_source)),)
        return Origin(frame, is_black, path, stamp_of(path), beside)


class _PlateLoader:
    def __init__(
        self, sequence: Sequence, shot: Shot, renderer: FrameRenderer, first: Path
    ) -> None:
        self._renderer = renderer
        self._loaded: tuple[Plate | None, bool] = (None, False)
        self._sequence = sequence
        read = SequenceReader(shot.plate_options, first)
        self._cache = FrameCache(sequence, read, _PLATES_BYTES, keeps_seen=False)

    def load(self, frame: PlannedFrame) -> None:
        plate, is_black = self._plate_at(frame.origin.frame), frame.origin.is_black
        if (plate, is_black) != self._loaded:
            self._renderer.load(_black(plate) if is_black else plate)
            self._loaded = (plate, is_black)

    def close(self) -> None:
        self._cache.close()

    def _plate_at(self, frame: int) -> Plate:
        needed = self._sequence.frames
        left = len(needed) - 1 - needed.index(frame)
        # Players loop, and so does the cache: at the end it must not look further.
        plate = self._cache.wait(frame, window=min(_AHEAD, left))
        if isinstance(plate, Plate):
            return plate
        if isinstance(plate, Damaged):
            raise InputError(plate.sentence)
        raise InputError(f"{self._sequence.path_at(frame)} is not there any more.")


def _black(plate: Plate) -> Plate:
    """Nothing where `plate` is: no light, and no surface."""
    color = np.zeros_like(plate.color)
    if not plate.has_alpha:
        color[..., 3] = 1.0
    if plate.coc_px is not None:
        return replace(plate, pixels=ReadPixels(color, coc_px=np.zeros_like(plate.coc_px)))
    nowhere_m = np.full(color.shape[:2], np.inf, np.float32)
    return replace(plate, pixels=ReadPixels(color, nowhere_m))

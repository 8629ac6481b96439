"""Take the sound of a movie along with its frames, in stereo at 48 kHz."""

from collections.abc import Iterator, Sequence
from contextlib import closing
from fractions import Fraction
from itertools import chain, pairwise
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from heatlens.core.model.curves.frames import exact_rate
from heatlens.deliver.export.plan import ExportPlan
from heatlens.media.files.movie_read import av, movie_at
from heatlens.media.files.opened_by_ending import movie_for_reading
from heatlens.media.files.picture_formats import in_movie
from heatlens.render.source.source import StampedFile

_RATE = 48_000
_SAME_RATE = 1e-4  # 23.976 is not 24
_LAYOUT, _FORMAT = "stereo", "s16"
_CODECS = {".mov": "pcm_s16le", ".mp4": "aac"}

Spot = tuple[Path, int]  # a movie, and the number of one of its frames, from 0
Samples = NDArray[np.int16]  # (N, 2)


def heard(plan: ExportPlan, frames_per_second: float) -> tuple[tuple[Spot | None, ...], str]:
    """Return whose sound goes with each frame, None for silence, and a sentence if it is left out.

    The frames must follow each other in one movie, and be shown at the rate of that movie.
    """
    spots = tuple(_spot(frame.origin.files) for frame in plan.frames)
    movie = next((spot[0] for spot in spots if spot is not None), None)
    silent = (None,) * len(spots)
    if movie is None or not movie_at(movie).has_sound:
        return silent, ""
    why = _why_silent(movie, spots, frames_per_second)
    return (silent, f"The sound of {movie} is left out, because {why}.") if why else (spots, "")


def _why_silent(path: Path, spots: Sequence[Spot | None], frames_per_second: float) -> str:
    rate = movie_at(path).rate
    if rate is None or abs(rate / exact_rate(frames_per_second) - 1) > _SAME_RATE:
        return "its frame rate is another"
    if any(b is None or a is None or b != (a[0], a[1] + 1) for a, b in pairwise(spots)):
        return "frames are left out too"
    return "" if has_whole_sound(path) else "it is damaged"


def _spot(files: Sequence[StampedFile]) -> Spot | None:
    return in_movie(files[0].path) if files else None


def has_whole_sound(path: Path) -> bool:
    """Decode all of the sound, so that no export fails when most frames are made."""
    try:
        with closing(_Reader(path)) as reader:
            return sum(map(len, reader.pieces)) > 0
    except (av().error.FFmpegError, ValueError):
        return False


class MovieSound:
    """Writes the sound of frames beside their pictures, exact to a sample."""

    def __init__(self, container: Any, suffix: str, rate: Fraction) -> None:
        """Add a stream to an open container, before its first frame is written."""
        self._container = container
        self._stream = container.add_stream(_CODECS[suffix], rate=_RATE, layout=_LAYOUT)
        self._rate = rate
        self._frames = self._written = 0
        self._reader: _Reader | None = None

    def add(self, spot: Spot | None) -> None:
        """Write the sound of the next frame; None is silence."""
        self._frames += 1
        count = self._sample(self._frames) - self._written
        samples = np.zeros((count, 2), np.int16)
        if spot is not None:
            samples = self._reader_of(spot[0]).read(self._sample(spot[1]), count)
        frame = av().AudioFrame.from_ndarray(samples.reshape(1, -1), format=_FORMAT, layout=_LAYOUT)
        frame.sample_rate, frame.pts, frame.time_base = _RATE, self._written, Fraction(1, _RATE)
        self._written += count
        self._container.mux(self._stream.encode(frame))

    def finish(self) -> None:
        """Write what the encoder still holds."""
        self._container.mux(self._stream.encode(None))
        self._close()

    def _sample(self, frame: int) -> int:
        return round(frame / self._rate * _RATE)

    def _reader_of(self, path: Path) -> "_Reader":
        if self._reader is None or self._reader.path != path:
            self._close()
            self._reader = _Reader(path)
        return self._reader

    def _close(self) -> None:
        if self._reader is not None:
            self._reader.close()


class _Reader:
    """Decodes the sound of a movie in order; asking for an earlier part begins again."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self._begin()

    def _begin(self) -> None:
        self._container = movie_for_reading(av(), self.path)
        self.pieces = self._decoded()
        self._kept, self._at = np.zeros((0, 2), np.int16), 0

    def close(self) -> None:
        """Close the file."""
        self._container.close()

    def read(self, start: int, count: int) -> Samples:
        """Return (count, 2) from sample `start` of the movie on; silence where it has none."""
        if start < self._at:
            self.close()
            self._begin()
        while self._at + len(self._kept) < start + count:
            piece = next(self.pieces, None)
            if piece is None:
                break
            self._kept = np.concatenate([self._kept, piece])
            passed = min(start - self._at, len(self._kept))
            self._kept, self._at = self._kept[passed:], self._at + passed
        there = self._kept[start - self._at : start - self._at + count]
        return np.pad(there, ((0, count - len(there)), (0, 0)))

    def _decoded(self) -> Iterator[Samples]:
        """Yield the sound piece by piece, beginning where the picture begins."""
        library, streams = av(), self._container.streams
        shown = streams.video[0]
        begin = float((shown.start_time or 0) * (shown.time_base or 0))
        resampler = library.AudioResampler(_FORMAT, _LAYOUT, _RATE)
        lead: int | None = None
        for frame in chain(self._container.decode(streams.audio[0]), [None]):
            for piece in resampler.resample(frame):
                samples = piece.to_ndarray().reshape(-1, 2)
                if lead is None:
                    lead = round((float(piece.time or 0) - begin) * _RATE)
                    samples = np.pad(samples, ((max(lead, 0), 0), (0, 0)))[max(-lead, 0) :]
                yield samples

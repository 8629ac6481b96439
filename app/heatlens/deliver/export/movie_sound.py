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
from heatlens.media.files.opened_by_ending import open_movie
from heatlens.media.files.picture_formats import movie_of_frame
from heatlens.media.sequence.sequence import StampedFile

_SAMPLE_RATE = 48_000
_RATE_TOLERANCE = 1e-4  # 23.976 is not 24
_LAYOUT, _FORMAT = "stereo", "s16"
_CODECS = {".mov": "pcm_s16le", ".mp4": "aac"}

SoundFrame = tuple[Path, int]  # a movie, and the number of one of its frames, from 0
Samples = NDArray[np.int16]  # (N, 2)


def find_sound(
    plan: ExportPlan, frames_per_second: float
) -> tuple[tuple[SoundFrame | None, ...], str]:
    """Return the source of the sound of each frame, and a message if the sound is left out.

    The source is a frame of a movie, or None for silence. The sound is kept only if the frames
    follow each other in one movie, and are shown at the rate of that movie.
    """
    sound_frames = tuple(_sound_frame(frame.origin.files) for frame in plan.frames)
    movie = next((sound_frame[0] for sound_frame in sound_frames if sound_frame is not None), None)
    silence = (None,) * len(sound_frames)
    if movie is None or not movie_at(movie).has_sound:
        return silence, ""
    reason = _reason_to_leave_out(movie, sound_frames, frames_per_second)
    return (
        (silence, f"The sound of {movie} is left out, because {reason}.")
        if reason
        else (sound_frames, "")
    )


def _reason_to_leave_out(
    path: Path, sound_frames: Sequence[SoundFrame | None], frames_per_second: float
) -> str:
    """Return why the sound of a movie is left out; "" if it is kept."""
    rate = movie_at(path).rate
    if rate is None or abs(rate / exact_rate(frames_per_second) - 1) > _RATE_TOLERANCE:
        return "its frame rate is another"
    if any(
        following is None or previous is None or following != (previous[0], previous[1] + 1)
        for previous, following in pairwise(sound_frames)
    ):
        return "frames are left out too"
    return "" if has_whole_sound(path) else "it is damaged"


def _sound_frame(files: Sequence[StampedFile]) -> SoundFrame | None:
    """Return the movie and frame number of a frame's first file; None if it is not in a movie."""
    return movie_of_frame(files[0].path) if files else None


def has_whole_sound(path: Path) -> bool:
    """Return True if all sound of a movie can be decoded.

    It is checked before the export, which else could fail after most frames are rendered.
    """
    try:
        with closing(_Reader(path)) as reader:
            return sum(map(len, reader.chunks)) > 0
    except (av().error.FFmpegError, ValueError):
        return False


class MovieSound:
    """Writes the sound of each frame to the movie, exact to a sample."""

    def __init__(self, container: Any, suffix: str, rate: Fraction) -> None:
        """Add a stream to an open container, before its first frame is written."""
        self._container = container
        self._stream = container.add_stream(_CODECS[suffix], rate=_SAMPLE_RATE, layout=_LAYOUT)
        self._rate = rate
        self._frames = self._written = 0
        self._reader: _Reader | None = None

    def add(self, sound_frame: SoundFrame | None) -> None:
        """Write the sound of the next frame; None is silence."""
        self._frames += 1
        count = self._first_sample(self._frames) - self._written
        samples = np.zeros((count, 2), np.int16)
        if sound_frame is not None:
            samples = self._reader_for(sound_frame[0]).read(
                self._first_sample(sound_frame[1]), count
            )
        frame = av().AudioFrame.from_ndarray(samples.reshape(1, -1), format=_FORMAT, layout=_LAYOUT)
        frame.sample_rate = _SAMPLE_RATE
        frame.pts = self._written
        frame.time_base = Fraction(1, _SAMPLE_RATE)
        self._written += count
        self._container.mux(self._stream.encode(frame))

    def finish(self) -> None:
        """Write the samples that the encoder still holds, and close the source."""
        self._container.mux(self._stream.encode(None))
        self._close()

    def _first_sample(self, frame: int) -> int:
        """Return the number of the first sample of a frame; frames count from 0."""
        return round(frame / self._rate * _SAMPLE_RATE)

    def _reader_for(self, path: Path) -> "_Reader":
        """Return the open reader of a movie; the reader of another movie is closed."""
        if self._reader is None or self._reader.path != path:
            self._close()
            self._reader = _Reader(path)
        return self._reader

    def _close(self) -> None:
        if self._reader is not None:
            self._reader.close()


class _Reader:
    """Decodes the sound of a movie in order; reading an earlier sample starts over."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self._begin()

    def _begin(self) -> None:
        """Open the movie at its start, with nothing decoded."""
        self._container = open_movie(av(), self.path)
        self.chunks = self._decode()
        self._decoded_samples, self._first_decoded = np.zeros((0, 2), np.int16), 0

    def close(self) -> None:
        """Close the file."""
        self._container.close()

    def read(self, start: int, count: int) -> Samples:
        """Return (count, 2) from sample `start` of the movie on; silence where it has none."""
        if start < self._first_decoded:
            self.close()
            self._begin()
        while self._first_decoded + len(self._decoded_samples) < start + count:
            chunk = next(self.chunks, None)
            if chunk is None:
                break
            self._decoded_samples = np.concatenate([self._decoded_samples, chunk])
            skip_count = min(start - self._first_decoded, len(self._decoded_samples))
            self._decoded_samples = self._decoded_samples[skip_count:]
            self._first_decoded = self._first_decoded + skip_count
        available = self._decoded_samples[
            start - self._first_decoded : start - self._first_decoded + count
        ]
        return np.pad(available, ((0, count - len(available)), (0, 0)))

    def _decode(self) -> Iterator[Samples]:
        """Yield the sound in chunks of (N, 2), beginning at the time of the first picture."""
        library, streams = av(), self._container.streams
        video = streams.video[0]
        begin = float((video.start_time or 0) * (video.time_base or 0))
        resampler = library.AudioResampler(_FORMAT, _LAYOUT, _SAMPLE_RATE)
        lead_samples: int | None = None
        for frame in chain(self._container.decode(streams.audio[0]), [None]):
            for chunk in resampler.resample(frame):
                samples = chunk.to_ndarray().reshape(-1, 2)
                if lead_samples is None:
                    lead_samples = round((float(chunk.time or 0) - begin) * _SAMPLE_RATE)
                    samples = np.pad(samples, ((max(lead_samples, 0), 0), (0, 0)))[
                        max(-lead_samples, 0) :
                    ]
                yield samples

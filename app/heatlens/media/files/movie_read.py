"""Decode single frames of movies, each exactly the one that was asked for."""

import os
import threading
from collections import OrderedDict
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from heatlens.core.base.errors import InputError
from heatlens.core.base.extras import import_extra
from heatlens.core.base.outside_text import one_line
from heatlens.core.base.paths import unreadable
from heatlens.media.files.opened_by_ending import movie_for_reading

if TYPE_CHECKING:
    from av import VideoCodecContext, VideoFrame, VideoStream

_OPEN_MOST = 4  # movies that stay open: a colour, its depth and two to compare with
_KEPT_MOST = 4  # decoded frames of each, because threads ask for frames in any order
_NEAR = 12  # frames ahead that are decoded rather than sought
_BACK = 8  # frames further back to seek to, where the first frame after a seek comes too late
_SAME_STEP = 1.5  # steps between frames that differ by more belong to a variable rate
_WHITE, _FULL = float(255 << 8), float(0xFFFF)  # values that FFmpeg gives white in 16 bits
_HD, _SD = 1, 5  # FFmpeg's numbers for the matrices of Rec.709 and Rec.601
_MATRICES = {1: 1, 4: 4, 5: 5, 6: 5, 7: 7, 9: 9}  # H.273 to FFmpeg's, of those that it converts
_SMALL_HEIGHT_PX = 576  # up to this height, colours without a tag are those of SD
_MAX_SIDE_PX = 1 << 14
_WITH_ALPHA = {"vp8": "libvpx", "vp9": "libvpx-vp9"}


def av() -> ModuleType:
    """Return PyAV, which is needed only for movies. Raises InputError that says what to install."""
    return import_extra("av")


@dataclass(frozen=True, eq=False)
class MovieFrame:
    """The stored values of a frame, upright, and the tags of its colours as numbers of H.273.

    values  (H, W, C): RGB, or RGBA with straight alpha
    white   the value of white
    bits    bits of a channel in the file
    """

    values: NDArray[np.uint16]
    white: float
    bits: int
    transfer: int
    primaries: int


class Movie:
    """An open movie, whose frames may be asked for on several threads.

    Raises InputError, when it is opened and for each frame, if the file is damaged.

    count         number of frames
    rate          frames a second on average; None if the file does not tell it
    is_even       every frame is shown for the same time
    timecode      of the first frame; "" if there is none
    comment       a text that its program wrote into the file; "" if there is none
    codec         the name of the codec for people
    pixel_aspect  width of a pixel over its height
    has_sound     it has a track of sound
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self._lock = threading.Lock()
        self._kept: OrderedDict[int, "VideoFrame"] = OrderedDict()
        self._frames: Iterator["VideoFrame"] = iter(())
        self._next: int | None = None  # number of the next decoded frame; None before a seek
        self._library = av()
        with self._failures_told():
            self._container = movie_for_reading(self._library, path)
            self._stream = self._picture_stream()
            self._with_alpha = _decoder_of_alpha(self._library, self._stream)
            self._times = self._all_times()
        self._numbers: dict[int | None, int] = {time: at for at, time in enumerate(self._times)}
        self.count = len(self._times)
        self._read_facts()

    def _read_facts(self) -> None:
        rate = self._stream.average_rate or self._stream.guessed_rate
        self.rate = Fraction(rate) if rate else None
        steps = sorted(after - before for before, after in pairwise(self._times))
        self.is_even = not steps or steps[-1] <= _SAME_STEP * steps[0] + 1
        metadata = (self._container.metadata, *(it.metadata for it in self._container.streams))
        self.timecode: str = next((it["timecode"] for it in metadata if "timecode" in it), "")
        self.comment: str = self._container.metadata.get("comment", "")
        context = self._stream.codec_context
        self.codec = str(context.codec.long_name)
        self.size = context.width, context.height
        if not all(0 < side <= _MAX_SIDE_PX for side in self.size):
            raise InputError(
                f"{self._path} has frames of {context.width} x {context.height} pixels; heatlens "
                f"takes 1 to {_MAX_SIDE_PX} a side."
            )
        self.has_sound = bool(self._container.streams.audio)
        self.pixel_aspect = float(self._stream.sample_aspect_ratio or 1)

    def frame(self, number: int) -> MovieFrame:
        """Return a frame; the first one is number 0. Raises InputError if there is none."""
        if not 0 <= number < self.count:
            raise InputError(f"{self._path} has {self.count} frames, and no frame {number + 1}.")
        with self._failures_told():
            with self._lock:
                decoded = self._kept.get(number) or self._decoded(number)
            self._check_size(decoded, number)
            return _values_of(decoded)

    def close(self) -> None:
        """Close the file once no other thread decodes."""
        with self._lock:
            self._kept.clear()
            self._container.close()

    def _picture_stream(self) -> "VideoStream":
        streams = self._container.streams.video
        covers = self._library.stream.Disposition.attached_pic
        stream: VideoStream | None = next(
            (it for it in streams if not it.disposition & covers), None
        )
        if stream is None:
            raise InputError(f"{self._path} has no moving picture, but only sound or data.")
        if stream.codec_context is None:
            raise InputError(f"{self._path} is damaged, or its codec is unknown to FFmpeg.")
        stream.thread_type = "AUTO"
        return stream

    def _all_times(self) -> tuple[int, ...]:
        """Return when each frame is shown, in order.

        Where every frame is coded by itself, the index has them; otherwise the packets are read,
        because they are stored in another order than shown.
        """
        entries = list(self._stream.index_entries)
        self._check_whole([entry.pos + entry.size for entry in entries])
        if self._stream.codec.intra_only and 1 < len(entries) == self._stream.frames:
            times = [entry.timestamp for entry in entries]
        else:
            packets = (it for it in self._container.demux(self._stream) if it.size)
            times = [it.pts for it in packets if it.pts is not None and not it.is_discard]
        if not times:
            raise InputError(f"{self._path} has no frames.")
        return tuple(sorted(set(times)))

    def _check_whole(self, ends: list[int]) -> None:
        """Raise InputError if the file ends before one of its frames does."""
        size = os.path.getsize(self._path)
        there = sum(end <= size for end in ends)
        if there < len(ends):
            raise InputError(
                f"{self._path} is cut short: it has {there} of its {len(ends)} frames. Copy or "
                "write it again."
            )

    def _decoded(self, number: int) -> "VideoFrame":
        """Return the decoded frame, and keep it with those that come before it."""
        if self._next is None or not 0 <= number - self._next <= _NEAR:
            self._seek(number)
        for frame in self._frames:
            at = self._numbers.get(frame.pts)
            if at is None:
                continue
            self._next = at + 1
            self._kept[at] = frame
            while len(self._kept) > _KEPT_MOST:
                self._kept.popitem(last=False)
            if at == number:
                return frame
            if at > number:
                break
        self._next = None
        raise InputError(f"Frame {number + 1} of {self._path} cannot be decoded: it is damaged.")

    def _seek(self, number: int) -> None:
        """Continue with the last frame that is at or before `number` and can be decoded alone."""
        back = 0
        while True:
            start = max(number - back, 0)
            self._container.seek(self._times[start], stream=self._stream)
            self._frames = self._frames_from_here()
            first = next(self._frames, None)
            at = None if first is None else self._numbers.get(first.pts)
            if start == 0 or (at is not None and at <= number):
                break
            back = max(2 * back, _BACK)
        self._frames = iter(()) if first is None else _with_first(first, self._frames)

    def _frames_from_here(self) -> Iterator["VideoFrame"]:
        decoder = self._with_alpha
        if decoder is None:
            yield from self._container.decode(self._stream)
            return
        decoder.flush_buffers()
        for packet in self._container.demux(self._stream):
            yield from decoder.decode(packet)

    def _check_size(self, frame: "VideoFrame", number: int) -> None:
        width, height = self.size
        if (frame.width, frame.height) != self.size:
            raise InputError(
                f"{self._path} changes its size from {width}x{height} to {frame.width}x"
                f"{frame.height} at its frame {number + 1}, but a movie has one size."
            )

    @contextmanager
    def _failures_told(self) -> Iterator[None]:
        """Turn failures of FFmpeg into sentences; other exceptions are faults of the program."""
        try:
            yield
        except FileNotFoundError as error:
            raise unreadable(self._path, error) from error
        except (self._library.error.FFmpegError, OSError, ValueError) as error:
            self._next = None
            why = one_line(getattr(error, "strerror", None) or str(error))
            raise InputError(
                f"{self._path} cannot be read: it is cut short, damaged or no such movie ({why})."
            ) from error


def _decoder_of_alpha(library: ModuleType, stream: "VideoStream") -> "VideoCodecContext | None":
    """Return a decoder for a WebM with alpha, which FFmpeg's own decoders leave out; else None."""
    name = _WITH_ALPHA.get(stream.codec_context.name)
    metadata = {entry.lower(): value for entry, value in stream.metadata.items()}
    if name is None or metadata.get("alpha_mode") != "1":
        return None
    decoder: VideoCodecContext = library.CodecContext.create(name, "r")
    decoder.extradata = stream.codec_context.extradata
    return decoder


def _with_first(first: "VideoFrame", others: Iterator["VideoFrame"]) -> Iterator["VideoFrame"]:
    yield first
    yield from others


def _values_of(frame: "VideoFrame") -> MovieFrame:
    """Convert a decoded frame to RGB of 16 bits, by the matrix and range of its tags."""
    parts = frame.format.components
    has_alpha = any(part.is_alpha for part in parts)
    usual = _SD if frame.height <= _SMALL_HEIGHT_PX else _HD
    kinds = av().video.reformatter.Interpolation
    turned = frame.reformat(
        format="rgba64le" if has_alpha else "rgb48le",
        src_colorspace=_MATRICES.get(frame.colorspace, usual),
        dst_color_range="JPEG",
        interpolation=kinds.BICUBIC | kinds.ACCURATE_RND | kinds.FULL_CHR_H_INT,
        threads=1,  # with several, bands of rows write over each other's edges
    ).to_ndarray()
    bits = max(part.bits for part in parts)
    white, opaque = _whites(bits, frame.format.is_rgb, len(parts) - has_alpha)
    if has_alpha:
        turned[:, :, 3] = np.minimum(turned[:, :, 3].astype(np.float32) * (white / opaque), white)
    values = np.rot90(np.asarray(turned, np.uint16), round(frame.rotation / 90) % 4)
    return MovieFrame(values, white, bits, frame.color_trc, frame.color_primaries)


def _whites(bits: int, is_rgb: bool, colors: int) -> tuple[float, float]:
    """Return what FFmpeg makes of white and of an opaque alpha in 16 bits.

    It fills the lower bits with zeros, but not for RGB of more than 8 bits.
    """
    if is_rgb and bits > 8:
        return _FULL, _FULL
    opaque = float((1 << 16) - (1 << 16 - bits))
    return (opaque if colors == 1 else _WHITE), opaque


_open: OrderedDict[tuple[Path, int, int], Movie] = OrderedDict()
_open_lock = threading.Lock()


def movie_at(path: Path) -> Movie:
    """Return the movie at `path`, which stays open for the frames that are asked for next."""
    try:
        status = path.stat()
    except OSError as error:
        raise unreadable(path, error) from error
    if not path.is_file():  # opening a pipe would wait for its writer
        raise unreadable(path)
    key = path, status.st_mtime_ns, status.st_size
    with _open_lock:
        opened = _open.pop(key, None) or Movie(path)
        _open[key] = opened
        closed = [_open.popitem(last=False)[1] for _ in range(len(_open) - _OPEN_MOST)]
    for movie in closed:
        movie.close()
    return opened

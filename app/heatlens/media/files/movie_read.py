"""Decode single frames of movies, each exactly the one that was asked for."""

import os
import threading
from collections import OrderedDict
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from fractions import Fraction
from itertools import chain, pairwise
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from heatlens.core.base.errors import InputError
from heatlens.core.base.extras import import_extra
from heatlens.core.base.outside_text import one_line
from heatlens.core.base.paths import unreadable_error
from heatlens.media.files.opened_by_ending import open_movie

if TYPE_CHECKING:
    from av import VideoCodecContext, VideoFrame, VideoStream

_OPEN_MOST = 4  # movies that stay open: a color, its depth and two to compare with
_CACHED_FRAMES_MOST = 4  # decoded frames of each, because threads ask for frames in any order
_DECODE_AHEAD_MOST = 12  # frames ahead up to which decoding on is preferred to a seek
_SEEK_BACK_STEP = 8  # least number of frames to seek further back if the first frame is too late
_SAME_STEP = 1.5  # largest ratio of the steps between frames at an even rate
_WHITE, _FULL_RANGE_WHITE = (
    float(255 << 8),
    float(0xFFFF),
)  # values that FFmpeg gives white in 16 bits
_HD, _SD = 1, 5  # FFmpeg's numbers for the matrices of Rec.709 and Rec.601
_MATRICES = {1: 1, 4: 4, 5: 5, 6: 5, 7: 7, 9: 9}  # by H.273: FFmpeg's number, if it converts it
_SMALL_HEIGHT_PX = 576  # up to this height, colors without a tag are those of SD
_MAX_SIDE_PX = 1 << 14
_WITH_ALPHA = {"vp8": "libvpx", "vp9": "libvpx-vp9"}


def av() -> ModuleType:
    """Return PyAV, which is needed only for movies. Raises InputError that says what to install."""
    return import_extra("av")


@dataclass(frozen=True, eq=False)
class MovieFrame:
    """The stored values of a frame, upright, and the tags of its colors as numbers of H.273.

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
    """An open movie, whose frames may be read on several threads.

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
        self._cached_frames: OrderedDict[int, "VideoFrame"] = OrderedDict()
        self._frames: Iterator["VideoFrame"] = iter(())
        self._next_number: int | None = None  # number of the next decoded frame; None before a seek
        self._library = av()
        with self._report_failures():
            self._container = open_movie(self._library, path)
            self._stream = self._picture_stream()
            self._alpha_decoder = _decoder_of_alpha(self._library, self._stream)
            self._frame_times = self._read_frame_times()
        self._number_by_time: dict[int | None, int] = {
            time: at for at, time in enumerate(self._frame_times)
        }
        self.count = len(self._frame_times)
        self._read_properties()

    def _read_properties(self) -> None:
        """Set the properties of the movie from its header. Raises InputError for an odd size."""
        rate = self._stream.average_rate or self._stream.guessed_rate
        self.rate = Fraction(rate) if rate else None
        steps = sorted(next_time - time for time, next_time in pairwise(self._frame_times))
        self.is_even = not steps or steps[-1] <= _SAME_STEP * steps[0] + 1
        streams = self._container.streams
        metadata = (self._container.metadata, *(stream.metadata for stream in streams))
        self.timecode: str = next(
            (entries["timecode"] for entries in metadata if "timecode" in entries), ""
        )
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
        with self._report_failures():
            with self._lock:
                decoded = self._cached_frames.get(number) or self._decode(number)
            self._check_size(decoded, number)
            return _convert_to_rgb(decoded)

    def close(self) -> None:
        """Close the file once no other thread decodes."""
        with self._lock:
            self._cached_frames.clear()
            self._container.close()

    def _picture_stream(self) -> "VideoStream":
        """Return the first stream of moving pictures. Raises InputError if there is none."""
        streams = self._container.streams.video
        cover_flag = self._library.stream.Disposition.attached_pic
        stream: VideoStream | None = next(
            (candidate for candidate in streams if not candidate.disposition & cover_flag), None
        )
        if stream is None:
            raise InputError(f"{self._path} has no moving picture, but only sound or data.")
        if stream.codec_context is None:
            raise InputError(
                f"{self._path} is damaged, or its codec is unknown to FFmpeg. Convert "
                "it to ProRes or to frames."
            )
        stream.thread_type = "AUTO"
        return stream

    def _read_frame_times(self) -> tuple[int, ...]:
        """Return the times at which the frames are shown, in order.

        If every frame is coded by itself, the index has the times. Otherwise the packets are read,
        because frames are stored in another order than shown. Raises InputError.
        """
        entries = list(self._stream.index_entries)
        self._check_complete([entry.pos + entry.size for entry in entries])
        if self._stream.codec.intra_only and 1 < len(entries) == self._stream.frames:
            times = [entry.timestamp for entry in entries]
        else:
            packets = (packet for packet in self._container.demux(self._stream) if packet.size)
            times = [
                packet.pts for packet in packets if packet.pts is not None and not packet.is_discard
            ]
        if not times:
            raise InputError(f"{self._path} has no frames: it is empty or damaged. Write it again.")
        return tuple(sorted(set(times)))

    def _check_complete(self, frame_ends: list[int]) -> None:
        """Raise InputError if the file ends before one of its frames does."""
        size = os.path.getsize(self._path)
        complete_count = sum(end <= size for end in frame_ends)
        if complete_count < len(frame_ends):
            raise InputError(
                f"{self._path} is cut short: it has {complete_count} of its {len(frame_ends)} "
                "frames. Copy or "
                "write it again."
            )

    def _decode(self, number: int) -> "VideoFrame":
        """Return the decoded frame, and cache it with the frames that were decoded before it."""
        if self._next_number is None or not 0 <= number - self._next_number <= _DECODE_AHEAD_MOST:
            self._seek(number)
        for frame in self._frames:
            frame_number = self._number_by_time.get(frame.pts)
            if frame_number is None:
                continue
            self._next_number = frame_number + 1
            self._cached_frames[frame_number] = frame
            while len(self._cached_frames) > _CACHED_FRAMES_MOST:
                self._cached_frames.popitem(last=False)
            if frame_number == number:
                return frame
            if frame_number > number:
                break
        self._next_number = None
        raise InputError(f"Frame {number + 1} of {self._path} cannot be decoded: it is damaged.")

    def _seek(self, number: int) -> None:
        """Continue with the last frame that is at or before `number` and can be decoded alone."""
        frames_back = 0
        while True:
            start = max(number - frames_back, 0)
            self._container.seek(self._frame_times[start], stream=self._stream)
            self._frames = self._frames_from_here()
            first = next(self._frames, None)
            first_number = None if first is None else self._number_by_time.get(first.pts)
            if start == 0 or (first_number is not None and first_number <= number):
                break
            frames_back = max(2 * frames_back, _SEEK_BACK_STEP)
        self._frames = iter(()) if first is None else chain((first,), self._frames)

    def _frames_from_here(self) -> Iterator["VideoFrame"]:
        """Yield the decoded frames from the current position of the file on."""
        decoder = self._alpha_decoder
        if decoder is None:
            yield from self._container.decode(self._stream)
            return
        decoder.flush_buffers()
        for packet in self._container.demux(self._stream):
            yield from decoder.decode(packet)

    def _check_size(self, frame: "VideoFrame", number: int) -> None:
        """Raise InputError for a frame of another size than the movie."""
        width, height = self.size
        if (frame.width, frame.height) != self.size:
            raise InputError(
                f"{self._path} changes its size from {width}x{height} to {frame.width}x"
                f"{frame.height} at its frame {number + 1}, but a movie has one size."
            )

    @contextmanager
    def _report_failures(self) -> Iterator[None]:
        """Convert failures of FFmpeg to InputErrors; other exceptions are faults of the program."""
        try:
            yield
        except FileNotFoundError as error:
            raise unreadable_error(self._path, error) from error
        except (self._library.error.FFmpegError, OSError, ValueError) as error:
            self._next_number = None
            reason = one_line(getattr(error, "strerror", None) or str(error))
            raise InputError(
                f"{self._path} cannot be read: it is cut short, damaged or not a movie "
                f"({reason}). Copy or write it again."
            ) from error


def _decoder_of_alpha(library: ModuleType, stream: "VideoStream") -> "VideoCodecContext | None":
    """Return a decoder for a WebM with alpha, which FFmpeg's default ones ignore; else None."""
    name = _WITH_ALPHA.get(stream.codec_context.name)
    metadata = {entry.lower(): value for entry, value in stream.metadata.items()}
    if name is None or metadata.get("alpha_mode") != "1":
        return None
    decoder: VideoCodecContext = library.CodecContext.create(name, "r")
    decoder.extradata = stream.codec_context.extradata
    return decoder


def _convert_to_rgb(frame: "VideoFrame") -> MovieFrame:
    """Convert a decoded frame to RGB of 16 bits, by the matrix and range of its tags."""
    components = frame.format.components
    has_alpha = any(component.is_alpha for component in components)
    default_matrix = _SD if frame.height <= _SMALL_HEIGHT_PX else _HD
    flags = av().video.reformatter.Interpolation
    rgb = frame.reformat(
        format="rgba64le" if has_alpha else "rgb48le",
        src_colorspace=_MATRICES.get(frame.colorspace, default_matrix),
        dst_color_range="JPEG",
        interpolation=flags.BICUBIC | flags.ACCURATE_RND | flags.FULL_CHR_H_INT,
        threads=1,  # with several, bands of rows write over each other's edges
    ).to_ndarray()
    bits = max(component.bits for component in components)
    white, opaque = _white_and_opaque(bits, frame.format.is_rgb, len(components) - has_alpha)
    if has_alpha:
        rgb[:, :, 3] = np.minimum(rgb[:, :, 3].astype(np.float32) * (white / opaque), white)
    values = np.rot90(np.asarray(rgb, np.uint16), round(frame.rotation / 90) % 4)
    return MovieFrame(values, white, bits, frame.color_trc, frame.color_primaries)


def _white_and_opaque(bits: int, is_rgb: bool, colors: int) -> tuple[float, float]:
    """Return the values of white and of an opaque alpha after FFmpeg's conversion to 16 bits.

    FFmpeg fills the lower bits with zeros, but not for RGB of more than 8 bits.
    """
    if is_rgb and bits > 8:
        return _FULL_RANGE_WHITE, _FULL_RANGE_WHITE
    opaque = float((1 << 16) - (1 << 16 - bits))
    return (opaque if colors == 1 else _WHITE), opaque


_open_movies: OrderedDict[tuple[Path, int, int], Movie] = OrderedDict()
_open_lock = threading.Lock()


def movie_at(path: Path) -> Movie:
    """Return the movie at `path`, opened once and kept open for further frames."""
    try:
        status = path.stat()
    except OSError as error:
        raise unreadable_error(path, error) from error
    if not path.is_file():  # opening a pipe would wait for its writer
        raise unreadable_error(path)
    key = path, status.st_mtime_ns, status.st_size
    with _open_lock:
        movie_for_path = _open_movies.pop(key, None) or Movie(path)
        _open_movies[key] = movie_for_path
        movies_to_close = [
            _open_movies.popitem(last=False)[1] for _ in range(len(_open_movies) - _OPEN_MOST)
        ]
    for movie in movies_to_close:
        movie.close()
    return movie_for_path

"""Write the pictures as a movie: ProRes for editing, H.264 for sharing.

Movies are tagged as Rec.709 and encoded with its matrix in video range, which players assume. This
is correct only for displays with the primaries of Rec.709; others are refused.
"""

import re
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np

from heatlens.core.base.errors import InputError
from heatlens.core.model.curves.frames import exact_rate
from heatlens.deliver.export.finished import is_complete
from heatlens.deliver.export.frame_files import MOVIE_WHITE, RenderedFrame, frame_timecode
from heatlens.deliver.export.job import ExportJob
from heatlens.deliver.export.movie_sound import MovieSound, SoundFrame
from heatlens.media.files.atomic_file import check_space, replace_atomically
from heatlens.media.files.marks import JOB_ATTRIBUTE, blurred_mark, marks_comment
from heatlens.media.files.movie_read import av
from heatlens.media.plate.picture.picture_write import quantize
from heatlens.media.plate.plate import FloatImage

_REC709 = 1  # code of the primaries, curve and matrix: ITU-T H.273, tables 2 to 4
_VIDEO_RANGE = 1  # FFmpeg's number for 16..235
_OTHER_PRIMARIES = re.compile(r"P3|2020|2100|\bPQ\b|HLG|2084|XYZ|DCI|HDR|Adobe", re.IGNORECASE)


_FRAMES_BEFORE_PREDICTION = 24  # after this many frames, their size predicts the rest


@dataclass(frozen=True)
class Codec:
    """An encoder of FFmpeg with its settings.

    least_bits_px  least bits per pixel of a frame for pictures with any detail; measured:
                   ProRes 5.7 to 6.3 and 0.1 for gray, H.264 0.17 to 6.0 and 0.02
    """

    name: str
    container: str
    pixel_format: str
    options: dict[str, str]
    least_bits_px: float


# With several threads or the rate control "mbtree", x264 sometimes makes different files from the
# same frames: 60 runs with one noisy picture gave three files with it, one without. One thread is
# still much faster than the rendering.
_X264 = {"crf": "14", "preset": "medium", "threads": "1", "mbtree": "0"}
_CODECS = {
    ".mov": Codec("prores_ks", "mov", "yuv422p10le", {"profile": "3"}, 2.0),  # 422 HQ
    ".mp4": Codec("libx264", "mp4", "yuv420p", _X264, 0.05),
}


@contextmanager
def movie_file(
    job: ExportJob, path: Path, fingerprint: str, sound_frames: Sequence[SoundFrame | None] = ()
) -> Iterator["Movie"]:
    """Yield a movie to write frames to, in order; `path` is replaced when the block succeeds.

    `sound_frames` has the source of the sound of each frame, see `movie_sound.find_sound`.

    Raises InputError if PyAV is missing, the display is not Rec.709 or writing fails.
    """
    library = av()
    check_display(job)
    rate, codec = exact_rate(job.shot.frames_per_second), _CODECS[job.output.suffix]
    with replace_atomically(path) as temporary_path, _ffmpeg_errors_as_input_errors(path, library):
        options = {"movie_timescale": str(rate.numerator), "movflags": "+faststart"}
        options["write_tmcd"] = "1"  # MPEG-4 files have no timecode track by default
        with library.open(
            str(temporary_path), "w", format=codec.container, options=options
        ) as container:
            marks = {JOB_ATTRIBUTE: fingerprint} | blurred_mark(not job.pinhole)
            container.metadata["comment"] = marks_comment(marks)
            movie = Movie(job, container, codec, rate, path.parent, sound_frames)
            yield movie
            movie.finish()
        if not is_complete(temporary_path, path.suffix):
            raise OSError("the file is incomplete; the disk may be full")


class Movie:
    """Writes frames of one size to an open container."""

    def __init__(
        self,
        job: ExportJob,
        container: Any,
        codec: Codec,
        rate: Fraction,
        folder: Path,
        sound_frames: Sequence[SoundFrame | None] = (),
    ) -> None:
        self._sound_frames = iter(sound_frames)
        self._has_sound = any(sound_frames)
        self._sound: MovieSound | None = None
        self._job = job
        self._folder = folder
        self._coded_bytes = self._coded_frames = 0
        self._container = container
        self._codec = codec
        self._rate = rate
        self._size = (0, 0)
        self._stream: Any = None
        self._has_failed = False

    def write(self, frame: RenderedFrame) -> None:
        """Write the next frame.

        Raises InputError if it has another size than the first one, or the disk has no space for
        the remaining frames.
        """
        height, width = frame.pixels.shape[:2]
        if self._stream is None:
            self._size = (width, height)
            is_square = self._job.display_settings.guides.desqueeze is not None
            self._stream = self._new_stream(1.0 if is_square else frame.plate.pixel_aspect_ratio)
            self._begin_timecode(frame)
            if self._has_sound:
                self._sound = MovieSound(self._container, self._job.output.suffix, self._rate)
        if self._size != (width, height):
            first = "x".join(map(str, self._size))
            raise InputError(
                f"{frame.plate.path} gives a picture of {width}x{height}, but the first frame was "
                f"{first}: a movie has one size. Export PNG or EXR frames instead."
            )
        self._check_disk_space()
        self._encode(self._convert_for_encoder(frame.pixels))
        if self._sound is not None:
            self._sound.add(next(self._sound_frames))

    def _check_disk_space(self) -> None:
        """Raise InputError if the disk has no space for the remaining frames.

        The need is estimated from the smallest size of the codec for the first frame, and from the
        average size of the coded frames later.
        """
        frames_left = len(self._job.frames) - self._coded_frames
        if not self._coded_frames:
            width, height = self._size
            needed_bytes = frames_left * width * height * self._codec.least_bits_px / 8
            check_space(self._folder, needed_bytes, f"a movie of {frames_left} frames")
        elif self._coded_frames >= _FRAMES_BEFORE_PREDICTION:
            needed_bytes = frames_left * self._coded_bytes / self._coded_frames
            check_space(self._folder, needed_bytes, f"{frames_left} more frames as those before")

    def finish(self) -> None:
        """Write the frames that the encoder still holds."""
        if self._stream is not None:
            self._encode(None)
        if self._sound is not None:
            self._sound.finish()

    def _new_stream(self, pixel_aspect_ratio: float) -> object:
        """Return a new video stream of the container; its width and height are made even."""
        stream = self._container.add_stream(
            self._codec.name, rate=self._rate, options=self._codec.options
        )
        stream.width, stream.height = (side + side % 2 for side in self._size)
        stream.pix_fmt = self._codec.pixel_format
        context = stream.codec_context
        context.sample_aspect_ratio = Fraction(pixel_aspect_ratio).limit_denominator(1000)
        context.color_primaries = context.color_trc = context.colorspace = _REC709
        context.color_range = _VIDEO_RANGE
        return stream

    def _begin_timecode(self, frame: RenderedFrame) -> None:
        """Set the timecode of the first frame, from which the container's track counts on."""
        timecode = frame_timecode(self._job, frame.planned, frame.plate)
        if timecode is not None:
            self._container.metadata["timecode"] = str(timecode)

    def _convert_for_encoder(self, display: FloatImage) -> object:
        """Return display values (H, W, 3) as a video frame with even sides.

        The last row and column are repeated to make the sides even. Only one thread converts: with
        several, FFmpeg's bands of rows write over each other's edges if the width is not a multiple
        of its block size.
        """
        height, width = display.shape[:2]
        even_sized = np.pad(display, ((0, height % 2), (0, width % 2), (0, 0)), mode="edge")
        levels = quantize(even_sized, np.uint16, MOVIE_WHITE)
        frame = av().VideoFrame.from_ndarray(levels, format="rgb48le")
        coded = frame.reformat(
            format=self._codec.pixel_format,
            dst_colorspace="ITU709",
            dst_color_range="MPEG",
            threads=1,
        )
        coded.color_primaries = coded.color_trc = _REC709  # ProRes writes them into every frame
        return coded

    def _encode(self, frame: object) -> None:
        """Encode a frame, but never after a failed write, because FFmpeg would end the process."""
        if self._has_failed:
            raise OSError("an earlier frame of it could not be written")
        self._has_failed = True
        for packet in self._stream.encode(frame):
            self._coded_bytes += packet.size
            self._coded_frames += 1
            self._container.mux(packet)
        self._has_failed = False


def check_display(job: ExportJob) -> None:
    """Raise InputError unless the movie is for a display with the primaries of Rec.709."""
    display = job.display_settings.transform.display
    if _OTHER_PRIMARIES.search(display):
        raise InputError(
            f"{display} is not a Rec.709 display, but the movie is tagged as Rec.709: its colours "
            "would be wrong in every player. Choose another --display, or export PNG."
        )


@contextmanager
def _ffmpeg_errors_as_input_errors(path: Path, library: ModuleType) -> Iterator[None]:
    """Turn an error of FFmpeg in the block into an InputError that names the file."""
    try:
        yield
    except library.error.FFmpegError as error:
        raise InputError(
            f"{path} could not be written as a movie ({error.strerror or error}): export frames, "
            "or another kind of movie."
        ) from error

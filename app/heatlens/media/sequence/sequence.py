"""Find the frames of a sequence such as plate.####.exr on disk, with gaps, and scan it again."""

import os
from bisect import bisect_left, bisect_right
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Literal

from heatlens.core.base.errors import InputError
from heatlens.media.files.picture_formats import file_on_disk, movie_of_frame, parse_movie_name
from heatlens.media.sequence.names import NameForm, frames_text

# What to show for a frame without a file: the nearest earlier one (else the first), black, or
# stop with an error.
MissingPolicy = Literal["hold", "black", "stop"]
# Time of the last change in nanoseconds, size in bytes, and the number of a frame of a movie.
Stamp = tuple[int, ...]

STILL_FRAME = 1  # frame number of a picture without a number in its name


@dataclass(frozen=True)
class Sequence:
    """The wanted frames of a numbered picture, and those that had a file at the last scan.

    `frames` and `present` are sorted, and `present` is a subset of `frames`. `frame_range` is the
    text with which frames were chosen; None means all frames, including those that appear later.
    """

    folder: Path
    form: NameForm
    frames: tuple[int, ...]
    present: tuple[int, ...]
    frame_range: str | None = None

    @property
    def first(self) -> int:
        """The first wanted frame."""
        return self.frames[0]

    @property
    def last(self) -> int:
        """The last wanted frame."""
        return self.frames[-1]

    @property
    def is_single(self) -> bool:
        """True if only one frame is wanted."""
        return len(self.frames) == 1

    @cached_property
    def missing(self) -> tuple[int, ...]:
        """The wanted frames that had no file."""
        return tuple(sorted(set(self.frames) - set(self.present)))

    @property
    def pattern(self) -> str:
        """The path that `find_sequence` finds again, together with `frame_range`: shot.####.exr.

        If the name itself contains notation marks, it is the path of one of the files instead.
        """
        if parse_movie_name(self.folder) is not None and not os.path.isdir(self.folder):
            return str(self.folder)
        is_notation = self.form.padding and self.form.is_notation
        first = self.form.name_at((self.present or self.frames)[0])
        return str(self.folder / (self.form.text if is_notation else first))

    def path_at(self, frame: int) -> Path:
        """Return the path of the file of `frame`, whether it exists or not."""
        return self.folder / self.form.name_at(frame)

    def frame_at(self, path: str | os.PathLike[str]) -> int | None:
        """Return the frame whose file is `path`; None if it is none of the wanted ones."""
        name = Path(path).name
        frames = self.form.frames_in([name]) if self.form.padding else (STILL_FRAME,)
        return next(
            (
                frame
                for frame in frames
                if frame in self._frame_set and self.path_at(frame).name == name
            ),
            None,
        )

    @cached_property
    def _frame_set(self) -> frozenset[int]:
        return frozenset(self.frames)

    def has_file(self, frame: int) -> bool:
        """Return True if `frame` is wanted and had a file."""
        index = bisect_left(self.present, frame)
        return self.present[index : index + 1] == (frame,)

    def shown_frame(self, frame: int, policy: MissingPolicy = "hold") -> int | None:
        """Return `frame`, or the frame that is shown in its place; None for black.

        Raises InputError if `frame` has no file and the policy is `stop`.
        """
        if self.has_file(frame):
            return frame
        if policy == "stop":
            raise InputError(
                f"{self.path_at(frame)} is missing: there are {frames_text(self.present)}."
            )
        if policy == "black" or not self.present:
            return None
        return self.present[max(bisect_right(self.present, frame) - 1, 0)]

    def resolve(self, frame: int, policy: MissingPolicy = "hold") -> Path | None:
        """Return the file to show for `frame`, or None for black.

        Raises InputError as `shown_frame` does.
        """
        shown_number = self.shown_frame(frame, policy)
        return None if shown_number is None else self.path_at(shown_number)


def stamp_of(path: Path) -> Stamp | None:
    """Return a value that changes when the file of a frame does; None if there is no file."""
    movie = movie_of_frame(path)
    try:
        status = file_on_disk(path).stat()
    except OSError:
        return None
    return status.st_mtime_ns, status.st_size, *(() if movie is None else movie[1:])


@dataclass(frozen=True)
class StampedFile:
    """A file and its stamp from before it was read; None for a missing file."""

    path: Path
    stamp: Stamp | None


def stamp_files(paths: Iterable[Path]) -> tuple[StampedFile, ...]:
    """Return the files with their current stamps."""
    return tuple(StampedFile(path, stamp_of(path)) for path in paths)

"""Find the frames of a sequence such as plate.####.exr on disk, with gaps, and scan it again."""

import os
import re
from bisect import bisect_left, bisect_right
from collections.abc import Mapping
from dataclasses import dataclass, replace
from difflib import get_close_matches
from functools import cached_property
from pathlib import Path
from typing import Literal

from heatlens.core.base.errors import InputError
from heatlens.media.files.movie_read import movie_at
from heatlens.media.files.picture_formats import (
    file_on_disk,
    in_movie,
    is_picture,
    movie_frame_name,
    movie_named,
)
from heatlens.media.sequence.names import (
    MAX_FRAMES,
    NameForm,
    are_frames,
    form_of,
    frames_text,
    padding_of,
    parse_frames,
    parse_pattern,
    sequences_among,
)

# What to show for a frame without a file: the nearest earlier one (else the first), black, or
# stop with an error.
MissingPolicy = Literal["hold", "black", "stop"]
# Time of the last change in nanoseconds, size in bytes, and the number of a frame of a movie.
Stamp = tuple[int, ...]

_STILL_FRAME = 1  # frame number of a picture without a number in its name
_NOTATIONS = "shot.####.exr, shot.%04d.exr, shot.@@@@.exr or shot.$F4.exr"
# How other programs and shells write a frame number: [0001-0003], {frame:04d}, <F4>, * and ?.
_FOREIGN = re.compile(r"\[[^\]]*\]|\{[^}]*\}|<[^>]*>|[*?]+")
_NEAR_NAMES = 3  # how many an error lists


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
        """True for a single frame."""
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
        if movie_named(self.folder) is not None and not os.path.isdir(self.folder):
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
        frames = self.form.frames_in([name]) if self.form.padding else (_STILL_FRAME,)
        return next((f for f in frames if f in self._wanted and self.path_at(f).name == name), None)

    @cached_property
    def _wanted(self) -> frozenset[int]:
        return frozenset(self.frames)

    def has(self, frame: int) -> bool:
        """Return True if `frame` is wanted and had a file."""
        at = bisect_left(self.present, frame)
        return self.present[at : at + 1] == (frame,)

    def shown_frame(self, frame: int, policy: MissingPolicy = "hold") -> int | None:
        """Return `frame`, or the frame that is shown in its place; None for black.

        Raises InputError if `frame` has no file and the policy is `stop`.
        """
        if self.has(frame):
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
        shown = self.shown_frame(frame, policy)
        return None if shown is None else self.path_at(shown)


def find_sequence(
    text: str | os.PathLike[str], frames: str | None = None, *, whole: bool = True
) -> Sequence:
    """Find the sequence for `text`: a pattern, a folder with one sequence, or one of its files.

    Patterns are shot.####.exr, shot.%04d.exr, shot.@@@@.exr, shot.$F4.exr, also with a range before
    the digits (shot.1001-1100x2####.exr); a single # matches any padding. `frames`, such as
    1001-1100x2, takes precedence over a range in the pattern; with neither, all frames from the
    first file to the last are wanted. If `whole` is False, a file stands only for its own frame. A
    file without a number is a sequence of one frame. A movie stands for a folder of its frames.
    Raises InputError that names what was looked for and what was found instead.
    """
    path = Path(os.path.expanduser(text))
    if os.path.isdir(path) or _movie_frames_in(path) is not None:
        names = _names_in(path)
        return _sequence_of(path, names, _form_of_folder(path, names), frames)
    if not os.path.isdir(path.parent) and _movie_frames_in(path.parent) is None:
        raise InputError(f"{path} cannot be found: the folder {path.parent} does not exist.")
    names = _names_in(path.parent)
    if os.path.isfile(path) or path.name in (_movie_frames_in(path.parent) or ()):
        form, own_frames = _form_of_file(path, names, whole)
    else:
        form, own_frames = _form_of_pattern(path, names)
    return _sequence_of(path.parent, names, form, own_frames if frames is None else frames)


def rescanned(sequence: Sequence) -> Sequence:
    """Scan the folder of `sequence` again, and return the sequence as it is on disk now.

    Without a `frame_range` it grows with its files. It never shrinks, because keys may be set on
    frames that are being rendered again. Raises InputError if the folder cannot be read.
    """
    names = _names_in(sequence.folder)
    on_disk = _frames_among(sequence.form, names)
    wanted = sequence.frames
    if sequence.frame_range is None and on_disk:
        wanted = _span(sequence.folder, min(on_disk[0], wanted[0]), max(on_disk[-1], wanted[-1]))
    present = _shared(on_disk, wanted)
    return replace(sequence, frames=wanted, present=present)


def stamp_of(path: Path) -> Stamp | None:
    """Return a value that changes when the file does; None if there is no file."""
    movie = in_movie(path)
    try:
        status = file_on_disk(path).stat()
    except OSError:
        return None
    return status.st_mtime_ns, status.st_size, *(() if movie is None else movie[1:])


def _form_of_file(path: Path, names: list[str], whole: bool) -> tuple[NameForm, str | None]:
    """Return the form of the file at `path`, and its own frame range if it stands for itself."""
    form, frame = form_of(path.name)
    if frame is None:
        return form, None
    fitting = (replace(form, padding=padding) for padding in padding_of(form, names))
    form = next((fit for fit in fitting if fit.name_at(frame) == path.name), form)
    is_whole = whole and are_frames(form, form.frames_in(names))
    return form, None if is_whole else str(frame)


def _sequence_of(folder: Path, names: list[str], form: NameForm, frames: str | None) -> Sequence:
    """Return the sequence of `form` among the `names` in `folder`, limited to `frames` if given."""
    on_disk = _frames_among(form, names)
    if not on_disk:
        raise InputError(f"No file is called {folder / form.text}. {_near(form, names)}")
    if frames is None:
        return Sequence(folder, form, _span(folder, on_disk[0], on_disk[-1]), on_disk)
    wanted = parse_frames(frames)
    sequence = Sequence(folder, form, wanted, _shared(on_disk, wanted), frames)
    if not sequence.present:
        raise InputError(
            f"{sequence.pattern} has no file for frames {frames}: there are {frames_text(on_disk)}."
        )
    return sequence


def _form_of_folder(folder: Path, names: list[str]) -> NameForm:
    """Return the form of the only sequence in `folder`, which may also hold stills.

    EXR files take precedence over other formats. Raises InputError for several sequences or none.
    """
    exr = [name for name in names if name.lower().endswith(".exr")]
    by_form = sequences_among(exr or [name for name in names if is_picture(Path(name))])
    forms = [form for form, frames in by_form.items() if are_frames(form, frames)] or list(by_form)
    if len(forms) == 1:
        return forms[0]
    if not by_form:
        raise InputError(f"The folder {folder} holds no EXR file, and no other picture.")
    raise InputError(
        f"The folder {folder} holds more than one picture: {_listed(by_form)}. Name one of them."
    )


def _form_of_pattern(path: Path, names: list[str]) -> tuple[NameForm, str | None]:
    """Return the form in the name of `path`, with its padding, and the frames it names, if any."""
    parsed = parse_pattern(path.name)
    if parsed is None:
        plain, count = _FOREIGN.subn("", path.name)
        is_pattern = count or any(mark in path.name for mark in "#%@$")
        what = f"neither a file nor a pattern such as {_NOTATIONS}" if is_pattern else "not there"
        raise InputError(f"{path} is {what}. {_near(form_of(plain)[0], names)}")
    form, frames = parsed
    if form.padding != 1:
        return form, frames
    paddings = padding_of(form, names) or (1,)
    if len(paddings) > 1:
        forms = {(f := replace(form, padding=p)): f.frames_in(names) for p in paddings}
        raise InputError(f"{path} can mean {_listed(forms)}: write one # for each digit.")
    return replace(form, padding=paddings[0]), frames


def _names_in(folder: Path) -> list[str]:
    """Return the names of the files in `folder`, or of the frames of a movie."""
    frames = _movie_frames_in(folder)
    if frames is not None:
        return frames
    try:
        with os.scandir(folder) as entries:
            return [entry.name for entry in entries if entry.is_file()]
    except OSError as error:
        raise InputError(f"{folder} cannot be listed: {error.strerror or error}.") from error


def _movie_frames_in(path: Path) -> list[str] | None:
    """Return the names of the frames if `path` is a movie, else None."""
    named = movie_named(path)
    if named is None or not os.path.isfile(named[0]):
        return None
    movie, first = named
    return [movie_frame_name(movie, first + at) for at in range(movie_at(movie).count)]


def _frames_among(form: NameForm, names: list[str]) -> tuple[int, ...]:
    if form.padding:
        return form.frames_in(names)
    return (_STILL_FRAME,) if form.prefix in names else ()


def _span(folder: Path, first: int, last: int) -> tuple[int, ...]:
    """Return every frame from `first` to `last`."""
    if last - first >= MAX_FRAMES:
        raise InputError(
            f"The frames in {folder} go from {first} to {last}, more than {MAX_FRAMES}: name those "
            "that you want, as in 1001-1100."
        )
    return tuple(range(first, last + 1))


def _shared(frames: tuple[int, ...], wanted: tuple[int, ...]) -> tuple[int, ...]:
    """Return those of `frames` that are wanted, in order."""
    among = set(wanted)
    return tuple(frame for frame in frames if frame in among)


def _near(form: NameForm, names: list[str]) -> str:
    """Return a sentence on the most similar names in the folder, or else on any EXR files."""
    meant = sorted(name for name in names if name.startswith(f"{form.prefix}{form.suffix}."))
    if meant:  # the extension was left out
        return f"Did you mean {' or '.join(meant[:_NEAR_NAMES])}?"
    by_form = sequences_among(names)
    by_text = {f"{f.prefix}{f.suffix}": f for f in by_form}
    near = get_close_matches(f"{form.prefix}{form.suffix}", by_text, _NEAR_NAMES)
    if near and not by_form[by_text[near[0]]] and not form.padding:
        return f"Did you mean {by_text[near[0]].text}?"
    near = near or [text for text in by_text if text.lower().endswith(".exr")][:_NEAR_NAMES]
    if not near:
        return "The folder holds no EXR file."
    return f"The folder holds {_listed({by_text[text]: by_form[by_text[text]] for text in near})}."


def _listed(sequences: Mapping[NameForm, tuple[int, ...]]) -> str:
    """Return the names of sequences with their frames, as text for a sentence."""
    texts = (f"{f.text} ({frames_text(at)})" if at else f.text for f, at in sequences.items())
    return ", ".join(sorted(texts))

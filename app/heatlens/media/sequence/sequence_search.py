"""Find the sequence that a path or a pattern names, and scan its folder again."""

import os
import re
from collections.abc import Mapping
from dataclasses import replace
from difflib import get_close_matches
from pathlib import Path

from heatlens.core.base.errors import InputError
from heatlens.core.base.named_paths import path_note
from heatlens.media.files.picture_formats import is_picture, movie_frame_name, parse_movie_name
from heatlens.media.sequence.names import (
    MAX_FRAMES,
    NameForm,
    are_frames,
    frames_text,
    group_sequences,
    paddings_of,
    parse_frame_name,
    parse_frames,
    parse_pattern,
)
from heatlens.media.sequence.sequence import STILL_FRAME, Sequence


def rescan(sequence: Sequence) -> Sequence:
    """Scan the folder of `sequence` again, and return the sequence as it is on disk now.

    Without a `frame_range` it grows with its files. It never shrinks, because keys may be set on
    frames that are being rendered again. Raises InputError if the folder cannot be read.
    """
    names = _names_in(sequence.folder)
    on_disk = _frames_among(sequence.form, names)
    wanted = sequence.frames
    if sequence.frame_range is None and on_disk:
        wanted = _frame_span(
            sequence.folder, min(on_disk[0], wanted[0]), max(on_disk[-1], wanted[-1])
        )
    present = _keep_wanted(on_disk, wanted)
    return replace(sequence, frames=wanted, present=present)


def _names_in(folder: Path) -> list[str]:
    """Return the names of the files in `folder`, or of the frames of a movie. Raises InputError."""
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
    from heatlens.media.files.movie_read import movie_at

    movie_and_first = parse_movie_name(path)
    if movie_and_first is None or not os.path.isfile(movie_and_first[0]):
        return None
    movie, first = movie_and_first
    return [movie_frame_name(movie, first + index) for index in range(movie_at(movie).count)]


def _frames_among(form: NameForm, names: list[str]) -> tuple[int, ...]:
    """Return the frames of `form` among `names`; one frame for a file without a number."""
    if form.padding:
        return form.frames_in(names)
    return (STILL_FRAME,) if form.prefix in names else ()


def _frame_span(folder: Path, first: int, last: int) -> tuple[int, ...]:
    """Return every frame from `first` to `last`. Raises InputError."""
    if last - first >= MAX_FRAMES:
        raise InputError(
            f"The frames in {folder} go from {first} to {last}, more than {MAX_FRAMES}: name those "
            "that you want, as in 1001-1100."
        )
    return tuple(range(first, last + 1))


def _keep_wanted(frames: tuple[int, ...], wanted: tuple[int, ...]) -> tuple[int, ...]:
    """Return those of `frames` that are wanted, in order."""
    wanted_set = set(wanted)
    return tuple(frame for frame in frames if frame in wanted_set)


_NOTATIONS = "shot.####.exr, shot.%04d.exr, shot.@@@@.exr or shot.$F4.exr"
# How other programs and shells write a frame number: [0001-0003], {frame:04d}, <F4>, * and ?.
_FOREIGN_NOTATION = re.compile(r"\[[^\]]*\]|\{[^}]*\}|<[^>]*>|[*?]+")
_NEAR_NAMES = 3  # how many an error lists


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
        return _sequence_of(path, names, _find_form_in_folder(path, names), frames)
    if not os.path.isdir(path.parent) and _movie_frames_in(path.parent) is None:
        raise InputError(
            f"{path} cannot be found: the folder {path.parent} does not exist.{path_note(path)}"
        )
    names = _names_in(path.parent)
    if os.path.isfile(path) or path.name in (_movie_frames_in(path.parent) or ()):
        form, own_frames = _form_of_existing_file(path, names, whole)
    else:
        form, own_frames = _form_of_pattern(path, names)
    return _sequence_of(path.parent, names, form, own_frames if frames is None else frames)


def _form_of_existing_file(
    path: Path, names: list[str], whole: bool
) -> tuple[NameForm, str | None]:
    """Return the form of the file at `path`, and its frame range; None for its whole sequence."""
    form, frame = parse_frame_name(path.name)
    if frame is None:
        return form, None
    candidates = (replace(form, padding=padding) for padding in paddings_of(form, names))
    form = next(
        (candidate for candidate in candidates if candidate.name_at(frame) == path.name), form
    )
    is_whole = whole and are_frames(form, form.frames_in(names))
    return form, None if is_whole else str(frame)


def _sequence_of(folder: Path, names: list[str], form: NameForm, frames: str | None) -> Sequence:
    """Return the sequence of `form` among the `names` in `folder`, limited to `frames` if given."""
    on_disk = _frames_among(form, names)
    if not on_disk:
        raise InputError(f"No file is called {folder / form.text}. {_suggestion(form, names)}")
    if frames is None:
        return Sequence(folder, form, _frame_span(folder, on_disk[0], on_disk[-1]), on_disk)
    wanted = parse_frames(frames)
    sequence = Sequence(folder, form, wanted, _keep_wanted(on_disk, wanted), frames)
    if not sequence.present:
        raise InputError(
            f"{sequence.pattern} has no file for frames {frames}: there are {frames_text(on_disk)}."
        )
    return sequence


def _find_form_in_folder(folder: Path, names: list[str]) -> NameForm:
    """Return the form of the only sequence in `folder`, which may also hold stills.

    EXR files take precedence over other formats. Raises InputError for several sequences or none.
    """
    exr = [name for name in names if name.lower().endswith(".exr")]
    by_form = group_sequences(exr or [name for name in names if is_picture(Path(name))])
    forms = [form for form, frames in by_form.items() if are_frames(form, frames)] or list(by_form)
    if len(forms) == 1:
        return forms[0]
    if not by_form:
        raise InputError(f"The folder {folder} holds no EXR file, and no other picture.")
    raise InputError(
        f"The folder {folder} holds more than one picture: {_list_sequences(by_form)}. Name one "
        "of them."
    )


def _form_of_pattern(path: Path, names: list[str]) -> tuple[NameForm, str | None]:
    """Return the form in the name of `path`, with its padding, and the frames it names, if any."""
    parsed = parse_pattern(path.name)
    if parsed is None:
        plain_name, count = _FOREIGN_NOTATION.subn("", path.name)
        is_pattern = count or any(mark in path.name for mark in "#%@$")
        problem = (
            f"neither a file nor a pattern such as {_NOTATIONS}" if is_pattern else "not there"
        )
        raise InputError(
            f"{path} is {problem}. {_suggestion(parse_frame_name(plain_name)[0], names)}"
        )
    form, frames = parsed
    if form.padding != 1:
        return form, frames
    paddings = paddings_of(form, names) or (1,)
    if len(paddings) > 1:
        forms = {
            (padded_form := replace(form, padding=padding)): padded_form.frames_in(names)
            for padding in paddings
        }
        raise InputError(f"{path} can mean {_list_sequences(forms)}: write one # for each digit.")
    return replace(form, padding=paddings[0]), frames


def _suggestion(form: NameForm, names: list[str]) -> str:
    """Return a sentence on the most similar names in the folder, or else on any EXR files."""
    extended_names = sorted(
        name for name in names if name.startswith(f"{form.prefix}{form.suffix}.")
    )
    if extended_names:  # the extension was left out
        return f"Did you mean {' or '.join(extended_names[:_NEAR_NAMES])}?"
    by_form = group_sequences(names)
    by_text = {f"{name_form.prefix}{name_form.suffix}": name_form for name_form in by_form}
    similar = get_close_matches(f"{form.prefix}{form.suffix}", by_text, _NEAR_NAMES)
    if similar and not by_form[by_text[similar[0]]] and not form.padding:
        return f"Did you mean {by_text[similar[0]].text}?"
    similar = similar or [text for text in by_text if text.lower().endswith(".exr")][:_NEAR_NAMES]
    if not similar:
        return "The folder holds no EXR file."
    return (
        "The folder holds "
        f"{_list_sequences({by_text[text]: by_form[by_text[text]] for text in similar})}."
    )


def _list_sequences(sequences: Mapping[NameForm, tuple[int, ...]]) -> str:
    """Return the names of sequences with their frames, as text for a sentence."""
    texts = (
        f"{form.text} ({frames_text(frames)})" if frames else form.text
        for form, frames in sequences.items()
    )
    return ", ".join(sorted(texts))

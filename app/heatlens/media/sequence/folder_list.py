"""List a folder for choosing pictures: its folders, files and numbered sequences."""

import os
import re
from dataclasses import dataclass
from pathlib import Path

from heatlens.core.base.errors import InputError
from heatlens.media.files.picture_formats import MOVIES_READ
from heatlens.media.sequence.names import NameForm, are_frames, group_sequences
from heatlens.media.sequence.sequence import Sequence

_DIGITS = re.compile(r"(\d+)")
# Numbers in names of text files are versions, and a movie holds all its frames.
_NO_FRAMES = (".json", *MOVIES_READ)


@dataclass(frozen=True)
class Entry:
    """A file, or a numbered sequence of files."""

    name: str  # plate.exr or shot.####.exr
    path: Path  # the file, or the pattern that opens the sequence
    written_s: float  # when its (last) file was written, seconds since 1970
    sequence: Sequence | None = None

    @property
    def frames_text(self) -> str:
        """First and last frame, and how many frames are missing; "" for a single file."""
        if self.sequence is None:
            return ""
        first, last = self.sequence.present[0], self.sequence.present[-1]
        missing = last - first + 1 - len(self.sequence.present)
        return f"{first}-{last}" + (f", {missing} missing" if missing else "")

    def file_at(self, frame: int) -> Path:
        """Return the file of `frame`, else that of the nearest earlier frame, else the first."""
        if self.sequence is None:
            return self.path
        return self.sequence.resolve(frame) or self.path


@dataclass(frozen=True)
class FolderList:
    """The names of the folders in a folder, and its pictures, both in natural order."""

    folder: Path
    folders: tuple[str, ...]
    entries: tuple[Entry, ...]


def list_folder(folder: Path, suffixes: tuple[str, ...], is_single: bool = False) -> FolderList:
    """List the folders in `folder` and its files with one of `suffixes`, but no hidden ones.

    With `is_single`, each file of a sequence is listed separately. Raises InputError if the folder
    cannot be read.
    """
    try:
        with os.scandir(folder) as scan:
            visible = [entry for entry in scan if not entry.name.startswith(".")]
            folders = [entry.name for entry in visible if os.path.isdir(entry.path)]
    except OSError as error:
        raise InputError(f"{folder} cannot be read: {error.strerror or error}.") from error
    folder_names = set(folders)
    names = [
        entry.name
        for entry in visible
        if entry.name.lower().endswith(suffixes) and entry.name not in folder_names
    ]
    entries = sorted(
        _list_entries(folder, names, is_single), key=lambda entry: natural_key(entry.name)
    )
    return FolderList(folder, tuple(sorted(folders, key=natural_key)), tuple(entries))


def natural_key(name: str) -> list[str | int]:
    """Return a sort key for natural order: shot9 before shot10, ignoring case."""
    return [int(part) if part.isdecimal() else part for part in _DIGITS.split(name.casefold())]


def _list_entries(folder: Path, names: list[str], is_single: bool) -> list[Entry]:
    """Return an entry for each file, or for each sequence of files unless `is_single`."""
    unnumbered_names = [name for name in names if name.lower().endswith(_NO_FRAMES)]
    entries = [Entry(name, folder / name, _modified_s(folder / name)) for name in unnumbered_names]
    for form, frames in group_sequences(set(names).difference(unnumbered_names)).items():
        if not are_frames(form, frames):
            single_names = [form.name_at(frame) for frame in frames or (0,)]
            entries += [
                Entry(single_name, folder / single_name, _modified_s(folder / single_name))
                for single_name in single_names
            ]
        elif is_single:
            entries += [_single_entry(folder, form, frame) for frame in frames]
        else:
            name = form.name_at(frames[-1])
            sequence = Sequence(folder, form, frames, frames)
            path = Path(sequence.pattern)
            entries.append(Entry(form.text, path, _modified_s(folder / name), sequence))
    return entries


def _single_entry(folder: Path, form: NameForm, frame: int) -> Entry:
    """Return the entry of one file of a sequence; its path opens only this frame."""
    name, path = form.name_at(frame), folder / form.name_at(frame)
    if form.is_notation:
        path = folder / f"{form.prefix}{frame}-{frame}{'#' * form.padding}{form.suffix}"
    return Entry(name, path, _modified_s(folder / name))


def _modified_s(path: Path) -> float:
    """Return the time of the last change; 0 for a file that is gone or a broken link."""
    try:
        return path.stat().st_mtime
    except OSError:
        return 0.0

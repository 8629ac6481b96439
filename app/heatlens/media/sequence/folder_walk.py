"""The state of a file dialog: the current folder, its entries and the selection."""

import os
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from heatlens.core.base.background import Background
from heatlens.core.base.errors import HeatlensError
from heatlens.core.base.paths import home_dir
from heatlens.media.sequence.folder_list import Entry, FolderList, list_folder
from heatlens.media.sequence.sequence_search import find_sequence


@dataclass(frozen=True)
class Purpose:
    """What a file is chosen for: the texts of the dialog and the files that it takes."""

    key: str  # under which the last folder is remembered
    title: str
    verb: str  # the label of the button
    more: tuple[str, ...]  # suffixes in lower case, after those of the pictures
    note: str  # a line of explanation for the user
    is_save: bool = False
    stays: bool = False  # the dialog stays open for another file
    pictures: Callable[[], tuple[str, ...]] = tuple  # suffixes of the pictures that it takes

    @property
    def suffixes(self) -> tuple[str, ...]:
        """All suffixes; a name to save without one gets the first."""
        return (*self.pictures(), *self.more)


@dataclass(frozen=True)
class ChosenFile:
    """A file to save, or a file or pattern to open; `entry` if it was picked in the list."""

    purpose: Purpose
    path: Path
    entry: Entry | None = None


@dataclass(frozen=True)
class _LookUpResult:
    """The result of looking up a path: a folder to show, a file, or a file in a folder to show."""

    listing: FolderList | None
    file: Path | None = None


class FolderWalk:
    """Browses folders. They are read on a thread, so that a slow disk does not block the window."""

    def __init__(self, purpose: Purpose, folder: Path, name: str, wake: Callable[[], None]) -> None:
        """Begin in `folder`, or in the nearest parent that exists.

        `name` is proposed for what is saved.
        """
        self.purpose = purpose
        self.name = name
        self.rows: list[str | Entry] = []  # folders by name, then pictures
        self.row = -1  # the selected one
        self.typed_path = str(folder)
        self.problem = ""
        self.existing_file: Path | None = (
            None  # an existing file; the user must agree to replace it
        )
        self.is_single = False  # each file of a sequence is a row
        self._listing: FolderList | None = None
        self._is_confirmed = False  # before the first folder was read: it is confirmed then
        self._reader: Background[_LookUpResult] = Background(wake)
        self._reader.start(lambda: _nearest_folder(folder, purpose))

    @property
    def is_reading(self) -> bool:
        """True while a folder is being read."""
        return self._reader.is_busy

    @property
    def can_confirm(self) -> bool:
        """True if there is something to open or to save."""
        return self._selected_entry is not None or (
            self.purpose.is_save and bool(self.name.strip())
        )

    @property
    def _selected_entry(self) -> str | Entry | None:
        return self.rows[self.row] if 0 <= self.row < len(self.rows) else None

    def go(self, text: str) -> None:
        """Begin to look up a folder, a file or a pattern that was typed; clear the last problem."""
        path = self._path(text)
        self.problem, self.existing_file, self._is_confirmed = "", None, False
        purpose = self.purpose
        is_single = self.is_single
        self._reader.start(lambda: _look_up(path, purpose, is_single))

    def list_single(self, is_single: bool) -> None:
        """List each file of a sequence as a row, or every sequence as one row."""
        self.is_single = is_single
        if self._listing is not None:
            self.go(str(self._listing.folder))

    def _path(self, text: str) -> Path:
        """Return a typed path, relative to the shown folder."""
        shown_folder = self._listing.folder if self._listing else home_dir()
        return Path(os.path.normpath(shown_folder / os.path.expanduser(text)))

    def poll(self) -> ChosenFile | None:
        """Show the folder that the thread has read; return a file that was typed or confirmed.

        Raises HeatlensError, once, if something is missing or cannot be read; `problem` keeps the
        sentence.
        """
        try:
            result = self._reader.poll()
        except HeatlensError as error:
            self.problem = str(error)
            raise
        if result is None:
            return None
        if result.listing is not None:
            self._show_folder(result.listing)
        if result.file is None:
            is_confirmed, self._is_confirmed = self._is_confirmed, False
            return self._file_to_write() if is_confirmed else None
        if self.purpose.is_save:
            self.name = result.file.name
            return None
        return ChosenFile(self.purpose, result.file)

    def _show_folder(self, listing: FolderList) -> None:
        """Show a folder. After a step up, select the folder that was left."""
        previous_folder = self._listing.folder if self._listing else listing.folder
        self._listing, self.typed_path = listing, str(listing.folder)
        self.rows = [*listing.folders, *listing.entries]
        is_up = previous_folder.parent == listing.folder and previous_folder.name in listing.folders
        self.row = self.rows.index(previous_folder.name) if is_up else -1

    def select(self, row: int) -> None:
        """Select a row, and take the name to save from its entry."""
        self.row, self.existing_file = min(max(row, 0), len(self.rows) - 1), None
        entry = self._selected_entry
        if isinstance(entry, Entry) and self.purpose.is_save:
            self.name = entry.file_at(0).name

    def type_name(self, name: str) -> None:
        """Use a typed name; no row is selected then."""
        self.name, self.row, self._is_confirmed = name, -1, False

    def confirm(self) -> ChosenFile | None:
        """Enter the selected folder and return None, or return the file to open or to save."""
        entry = self._selected_entry
        if isinstance(entry, str):
            self.go(entry)
            return None
        if self.purpose.is_save:
            return self._file_to_write()
        return None if entry is None else ChosenFile(self.purpose, entry.path, entry)

    def overwrite(self) -> ChosenFile | None:
        """Return the existing file as the choice, to replace it; None if none was asked about."""
        return None if self.existing_file is None else ChosenFile(self.purpose, self.existing_file)

    def _file_to_write(self) -> ChosenFile | None:
        """Return the file to write, with a suffix.

        Return None without a name; before the first folder was read, when `poll` returns the file;
        and if the file exists: `existing_file` is then to be asked about.
        """
        name = self.name.strip()
        self._is_confirmed = bool(name) and self._listing is None
        if not name or self._listing is None:
            return None
        if not name.lower().endswith(self.purpose.suffixes):
            name += self.purpose.suffixes[0]
        path = self._path(name)
        if os.path.lexists(path):
            self.existing_file = path
            return None
        return ChosenFile(self.purpose, path)


def _nearest_folder(folder: Path, purpose: Purpose) -> _LookUpResult:
    """Return the nearest existing folder; a remembered one may be gone. Runs on a thread."""
    existing_folder = next(
        (path for path in (folder, *folder.parents) if os.path.isdir(path)), home_dir()
    )
    return _LookUpResult(list_folder(existing_folder, purpose.suffixes))


def _look_up(path: Path, purpose: Purpose, is_single: bool) -> _LookUpResult:
    """List a folder; runs on a thread. Raises InputError if it cannot be read."""
    if os.path.isdir(path):
        return _LookUpResult(list_folder(path, purpose.suffixes, is_single))
    if purpose.is_save:
        return _LookUpResult(list_folder(path.parent, purpose.suffixes), path)
    find_sequence(path)
    return _LookUpResult(None, path)

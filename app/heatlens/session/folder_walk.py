"""The way through folders to a file: where one is, what is there, what is chosen."""

import os
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from heatlens.background import Background
from heatlens.errors import HeatlensError
from heatlens.paths import home_dir
from heatlens.sequence.folder_list import Entry, FolderList, list_folder
from heatlens.sequence.sequence import find_sequence


@dataclass(frozen=True)
class Purpose:
    """What a file is chosen for."""

    key: str  # by which the last folder is remembered
    title: str
    verb: str  # on the button that does it
    suffixes: tuple[str, ...]  # in small letters; a name to save that has none gets the first
    note: str  # a line for the person who chooses
    is_save: bool = False


@dataclass(frozen=True)
class Chosen:
    """A file to save, or a file or pattern to open; `entry` where it stood in the list."""

    purpose: Purpose
    path: Path
    entry: Entry | None = None


@dataclass(frozen=True)
class _Found:
    """What a path turned out to be: a folder to show, a file, or a file in a folder to show."""

    listing: FolderList | None
    file: Path | None = None


class FolderWalk:
    """Walks through folders, which are read on a thread: a slow disk holds up nothing."""

    def __init__(self, purpose: Purpose, folder: Path, name: str, wake: Callable[[], None]) -> None:
        """Begin in `folder`, or where it no longer is, as near above it as there is one.

        `name` is proposed for what is saved.
        """
        self.purpose = purpose
        self.name = name
        self.rows: list[str | Entry] = []  # folders by name, then pictures
        self.row = -1  # the one that is chosen
        self.typed = str(folder)
        self.problem = ""
        self.overwrites: Path | None = None  # asked about before it is written over
        self.is_single = False  # each file of a sequence is a row
        self._listing: FolderList | None = None
        self._reader: Background[_Found] = Background(wake)
        self._reader.start(lambda: _nearest_folder(folder, purpose))

    @property
    def is_reading(self) -> bool:
        """Return True while a folder is being read."""
        return self._reader.is_busy

    @property
    def can_take(self) -> bool:
        """Return True where there is something to open or to save."""
        return self._at_row is not None or (self.purpose.is_save and bool(self.name.strip()))

    @property
    def _at_row(self) -> str | Entry | None:
        return self.rows[self.row] if 0 <= self.row < len(self.rows) else None

    def go(self, text: str) -> None:
        """Look up a folder, a file or a pattern as it was typed."""
        path = self._path(text)
        self.problem, self.overwrites = "", None
        purpose = self.purpose
        is_single = self.is_single
        self._reader.start(lambda: _looked_up(path, purpose, is_single))

    def list_single(self, is_single: bool) -> None:
        """List each file of a sequence by itself, or every sequence as one row again."""
        self.is_single = is_single
        if self._listing is not None:
            self.go(str(self._listing.folder))

    def _path(self, text: str) -> Path:
        """Return a path as it was typed, seen from the folder that is shown."""
        here = self._listing.folder if self._listing else home_dir()
        return Path(os.path.normpath(here / os.path.expanduser(text)))

    def poll(self) -> Chosen | None:
        """Take what the thread found; a file that was typed is chosen.

        Raises HeatlensError, once, for what is not there or cannot be read; `problem` keeps saying
        it.
        """
        try:
            found = self._reader.poll()
        except HeatlensError as error:
            self.problem = str(error)
            raise
        if found is None:
            return None
        if found.listing is not None:
            self._show(found.listing)
        if found.file is None:
            return None
        if self.purpose.is_save:
            self.name = found.file.name
            return None
        return Chosen(self.purpose, found.file)

    def _show(self, listing: FolderList) -> None:
        """Show a folder; after a step up, the folder one comes from is selected."""
        before = self._listing.folder if self._listing else listing.folder
        self._listing, self.typed = listing, str(listing.folder)
        self.rows = [*listing.folders, *listing.entries]
        is_up = before.parent == listing.folder and before.name in listing.folders
        self.row = self.rows.index(before.name) if is_up else -1

    def choose(self, row: int) -> None:
        """Select a row; a name to save is taken from it."""
        self.row, self.overwrites = min(max(row, 0), len(self.rows) - 1), None
        entry = self._at_row
        if isinstance(entry, Entry) and self.purpose.is_save:
            self.name = entry.file_at(0).name

    def rename(self, name: str) -> None:
        """Take a typed name, in the place of the selected row."""
        self.name, self.row = name, -1

    def take(self) -> Chosen | None:
        """Go into the folder that is chosen, open the file, or save under the name."""
        entry = self._at_row
        if isinstance(entry, str):
            self.go(entry)
            return None
        if self.purpose.is_save:
            return self._named()
        return None if entry is None else Chosen(self.purpose, entry.path, entry)

    def overwrite(self) -> Chosen | None:
        """Agree to write over the file that is there."""
        return None if self.overwrites is None else Chosen(self.purpose, self.overwrites)

    def _named(self) -> Chosen | None:
        """Return the file to write; ask first about one that is there already."""
        name = self.name.strip()
        if not name or self._listing is None:
            return None
        if not name.lower().endswith(self.purpose.suffixes):
            name += self.purpose.suffixes[0]
        path = self._path(name)
        if os.path.lexists(path):
            self.overwrites = path
            return None
        return Chosen(self.purpose, path)


def _nearest_folder(folder: Path, purpose: Purpose) -> _Found:
    """Return the nearest folder that exists; one that was remembered may be gone. On a thread."""
    there = next((path for path in (folder, *folder.parents) if os.path.isdir(path)), home_dir())
    return _Found(list_folder(there, purpose.suffixes))


def _looked_up(path: Path, purpose: Purpose, is_single: bool) -> _Found:
    """List a folder, on a thread. Raises InputError for what cannot be read."""
    if os.path.isdir(path):
        return _Found(list_folder(path, purpose.suffixes, is_single))
    if purpose.is_save:
        return _Found(list_folder(path.parent, purpose.suffixes), path)
    find_sequence(path)
    return _Found(None, path)

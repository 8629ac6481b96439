"""Make a reel in the session and change it: more shots, fewer, another order; and save it."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path

from heatlens.core.base.background import Background
from heatlens.core.base.errors import HeatlensError
from heatlens.core.base.messages import Worker
from heatlens.core.model.shot.reel import CutFocus, Reel, ReelShot, shot_name
from heatlens.media.documents.reel_file import REEL_SUFFIX, write_reel
from heatlens.media.documents.shot_file import SHOT_SUFFIX, write_shot
from heatlens.render.source.reel_shots import join_frames, reel_shots
from heatlens.studio.session.files.open_reel import OpenReel
from heatlens.studio.session.files.reel_reading import focus_in_file
from heatlens.studio.session.files.shot_documents import ShotDocuments
from heatlens.studio.session.shared import Commands, Shared

_NEW_NAME = "reel"
_UNSAVED_REEL = Path("unsaved") / f"unsaved{REEL_SUFFIX}"  # in the settings folder

_Added = tuple[tuple[ReelShot, ...], tuple[CutFocus, ...]]


class ReelEditing(Commands, Worker):
    """Makes, changes and saves the open reel.

    A changed reel is kept in the settings folder, and listed with the recent files, until it is
    saved under its own name.
    """

    def __init__(
        self,
        shared: Shared,
        reel: OpenReel,
        documents: ShotDocuments,
        open_single: Callable[[str], None],
    ) -> None:
        """Set `open_single`, which opens a file that does not go into a reel."""
        super().__init__(shared)
        self._reel, self._documents, self._open_single = reel, documents, open_single
        self._names: tuple[str, ...] = ()  # files that are being added
        self._reader: Background[_Added] = Background(self._wake)
        self._namer: Background[tuple[Path, dict[str, Path]]] = Background(self._wake)
        self._writer: Background[tuple[Path, Reel]] = Background(self._wake)
        self._removal: tuple[str, Reel, Reel | None] | None = None  # shot, before and after

    def begin(self) -> bool:
        """Begin a reel with the open shot as its first; return False if nothing is open."""
        shot, path = self._editing.shot, self._documents.path
        if self._source.plate is None or shot.source is None:
            return False
        if self._source.why_shown_once:
            self._notify(self._source.why_shown_once)
            return True
        name = shot_name(self._documents.window_title.split(".")[0])
        frames = None if path else shot.in_out
        first_shot = ReelShot(name, str(path or shot.source), frames)
        self._reel.begin(Reel(_NEW_NAME, (first_shot,), shot.frames_per_second))
        self._keep()
        return True

    def add(self, names: Sequence[str]) -> None:
        """Begin to add files to the reel, or to a new one; frames of a sequence are one shot.

        A single file or sequence is opened by itself if no reel is open.
        """
        self._names = (*self._names, *names)
        self._reader.start(partial(_read_shots, self._names))

    def remove(self, number: int) -> None:
        """Remove a shot from the reel, not its files; leave the reel if it was the only one."""
        reel = self._reel.reel
        if reel is None or len(reel.shots) == 1:
            self._reel.leave()
            return
        shots = (*reel.shots[:number], *reel.shots[number + 1 :])
        self._change(reel.with_shots(shots))
        self._removal = reel.shots[number].name, reel, self._reel.reel

    @property
    def removed(self) -> tuple[str, Reel] | None:
        """The removed shot and the reel with it, if nothing in the reel has changed since."""
        name, before, after = self._removal or ("", None, None)
        return (name, before) if before is not None and after is self._reel.reel else None

    def put_back(self) -> None:
        """Give the reel back the shot that was removed last, at its place."""
        if self.removed is not None:
            self._change(self.removed[1])

    def move(self, number: int, new_number: int) -> None:
        """Move a shot to another place in the reel."""
        assert self._reel.reel is not None
        shots = list(self._reel.reel.shots)
        shots.insert(new_number, shots.pop(number))
        self._change(self._reel.reel.with_shots(shots))

    def save(self) -> bool:
        """Save the reel to its file; return False if it has none, or an edit of another program."""
        path = self._reel.path
        if path in (None, self._unsaved_path) or not path.name.lower().endswith(REEL_SUFFIX):
            return False
        self.save_as(path)
        return True

    def save_as(self, path: Path) -> None:
        """Begin to save the reel to this file, which is its file from now on.

        Shots without a file whose lens, keys or marks were changed are saved beside it.
        """
        reel = self._reel.reel
        if reel is None:
            return
        self._reel.path = path
        names: dict[str, str] = {}
        for shot in reel.shots:
            if self._reel.edited_shot(shot.source) is not None:
                names.setdefault(shot.source, shot.name)
        self._namer.start(partial(_name_files, path, names))

    def _save_under(self, path: Path, files: dict[str, Path]) -> None:
        """Save the reel to `path`, and its edited shots to `files`, given by their sources."""
        reel = self._reel.reel
        if reel is None:
            return
        for source, file in files.items():
            edited_shot = self._reel.edited_shot(source)
            if source == self._editing.shot.source:
                self._documents.save_as(file)
            elif edited_shot is not None:
                self._documents.write(partial(write_shot, file, edited_shot))
        shots = [replace(it, source=str(files.get(it.source, it.source))) for it in reel.shots]
        saved_reel = replace(reel, shots=tuple(shots))
        self._reel.change(saved_reel)
        self._writer.start(partial(_write, path, saved_reel))

    def _change(self, reel: Reel, added_focus: Sequence[CutFocus] = ()) -> None:
        self._reel.change(reel, added_focus)
        self._keep()

    @property
    def _unsaved_path(self) -> Path | None:
        """The file that keeps an unsaved reel; None without preferences."""
        preferences = self._preferences.path
        return None if preferences is None else preferences.parent / _UNSAVED_REEL

    def _keep(self) -> None:
        """Begin to keep the reel in the settings folder, until it is saved."""
        path, reel = self._unsaved_path, self._reel.reel
        if path is not None and reel is not None:
            self._documents.write(partial(_keep_reel, path, reel))
            self._preferences.remember_opened(str(path))

    def poll(self) -> None:
        """Use the shots that have been read, and report a saved reel; call this once a frame."""
        if (named := self._namer.poll()) is not None:
            self._save_under(*named)
        if (written := self._writer.poll()) is not None:
            self._finish_saving(*written)
        try:
            added = self._reader.poll()
        except HeatlensError:
            self._names = ()
            raise
        if added is not None:
            self._names = ()
            self._use_added(*added)

    def _finish_saving(self, path: Path, reel: Reel) -> None:
        """Report that the reel is saved, and delete the one in the settings folder."""
        self._reel.saved = reel
        kept_path = self._unsaved_path
        if kept_path is not None and kept_path != path:
            self._documents.write(partial(kept_path.unlink, missing_ok=True))
            self._preferences.forget_opened(str(kept_path))
        self._preferences.remember_opened(str(path))
        self._notify(f"Saved {path}.")

    def _use_added(self, shots: tuple[ReelShot, ...], focus: tuple[CutFocus, ...]) -> None:
        """Add the shots to the reel, or begin one with them; open a single one by itself."""
        reel = self._reel.reel
        if reel is not None:
            self._change(reel.with_shots((*reel.shots, *shots)), focus)
            self._notify(f"Added {', '.join(shot.name for shot in shots)} to the reel.")
        elif len(shots) == 1:
            self._open_single(shots[0].source)
        else:
            new_reel = Reel(_NEW_NAME, shots)
            self._reel.begin(new_reel)
            self._change(new_reel, focus)
            self._reel.go(0)


def _read_shots(names: tuple[str, ...]) -> _Added:
    """Return shots of files, and their focus; see `join_frames`. Raises InputError."""
    shots = reel_shots(join_frames(names))
    return shots, tuple(map(focus_in_file, shots))


def _keep_reel(path: Path, reel: Reel) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    write_reel(path, reel)


def _write(path: Path, reel: Reel) -> tuple[Path, Reel]:
    """Write a reel, and return what was written."""
    write_reel(path, reel)
    return path, reel


def _name_files(reel_path: Path, names: dict[str, str]) -> tuple[Path, dict[str, Path]]:
    """Return the file of a reel, and free names beside it for shot files, by their sources."""
    files: dict[str, Path] = {}
    for source, name in names.items():
        files[source] = _free_path(reel_path.parent, name, set(files.values()))
    return reel_path, files


def _free_path(folder: Path, name: str, taken: set[Path]) -> Path:
    """Return a name for a shot file in `folder` that no file has yet, and that is not `taken`."""
    number, path = 1, folder / f"{name}{SHOT_SUFFIX}"
    while path in taken or path.exists():
        number += 1
        path = folder / f"{name}_{number}{SHOT_SUFFIX}"
    return path

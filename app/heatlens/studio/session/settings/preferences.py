"""Load and save the preferences: what the program remembers between sessions."""

import json
import math
import os
from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from dataclasses import dataclass, field, fields, replace
from enum import StrEnum
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, TypeVar, get_type_hints

from heatlens.core.base.errors import InputError
from heatlens.core.base.paths import absolute, file_bytes
from heatlens.core.model.option import Values
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.core.model.view.guides import NO_GUIDES, USUAL_PEAKING, Guides, Peaking
from heatlens.core.model.view.view import ViewState
from heatlens.deliver.farm.connection import Met
from heatlens.media.files.atomic_file import FOR_THE_USER, locked, write_whole
from heatlens.media.files.json_record import JsonEntry, read_json, record_to_json
from heatlens.media.live.ring.channel_map import ChannelMap
from heatlens.studio.session.settings.export_place import HERE, ExportPlace, LeftExport
from heatlens.studio.session.settings.ui_sizes import SCALES
from heatlens.studio.session.time.playback import Ending

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

FILE_NAME = "preferences.json"
_FOLDERS_MAX = 200  # largest number of folders whose plate options are remembered
_EM_MOST = 1000.0  # largest font size in pixels
MEGABYTES_MOST = 10**8  # largest limit for rendered frames, more than any disk has
WINDOW_LEAST, _WINDOW_MOST = 200, 16384  # limits of a side of the window, in screen units


class Theme(StrEnum):
    """The colour theme of the interface."""

    DARK = "dark"
    LIGHT = "light"


@dataclass(frozen=True)
class Remembered:
    """The preferences, as an immutable value.

    recent         absolute paths of opened files, the latest first
    folders        the last folder of each file dialog, by purpose
    plates         plate options by folder, the latest choice last
    display, view  names in the colour config; "" for its defaults
    unit           unit of distances, "m" or "ft"
    guides         guide lines and mattes; the desqueeze is not remembered, each file has its own
    peaking        settings of the focus peaking
    window_size    in screen units; None if unknown
    is_maximized   whether the window was maximised
    hidden_panels  names of the closed panels
    layout         arrangement of the panels as ImGui writes it; "" for the original one
    layout_em      font size in pixels when the layout was written; 0 if unknown
    theme          the colour theme of the interface
    ui_scales      the user's scale of the interface, by monitor
    feed_labels    whether the second window shows the names of looks in a grid
    ending         what happens after the last played frame
    every_frame    True if playback waits for each frame; False if it keeps time
    keep_frames    whether frames of a shot are rendered ahead while idle
    memory_mb      memory limit for rendered frames in MB; 0 for a quarter of the free memory
    ring_maps      which channels of a controller turn which rings of the lens
    disk_mb        disk limit for rendered frames in MB; 0 keeps none on disk
    export_place   who made the frames of the last export
    left_exports   exports that a cluster goes on with, by source
    cluster        the scheduler to which the user agreed, which renders for the window
    """

    recent: tuple[str, ...] = ()
    folders: Mapping[str, str] = field(default_factory=dict)
    plates: Mapping[str, PlateOptions] = field(default_factory=dict)
    display: str = ""
    view: str = ""
    unit: Literal["m", "ft"] = "m"
    guides: Guides = NO_GUIDES
    peaking: Peaking = USUAL_PEAKING
    window_size: tuple[int, int] | None = None
    is_maximized: bool = False
    hidden_panels: tuple[str, ...] = ()
    layout: str = ""
    layout_em: float = 0.0
    theme: Theme = Theme.DARK
    ui_scales: Mapping[str, float] = field(default_factory=dict)
    feed_labels: bool = True
    ending: Ending = Ending.LOOP
    every_frame: bool = True
    keep_frames: bool = True
    memory_mb: int = 0
    disk_mb: int = 4000
    ring_maps: tuple[ChannelMap, ...] = ()
    export_place: ExportPlace = HERE
    left_exports: Mapping[str, LeftExport] = field(default_factory=dict)
    cluster: Met | None = None


class Preferences:
    """The current preferences, saved to a file if a path is given."""

    def __init__(self, now: Remembered | None = None, path: Path | None = None) -> None:
        """Keep preferences at `path`; None keeps them only as long as the program runs."""
        self.now = now or Remembered()
        self.path = path
        self.problem = ""  # a sentence about entries of the file that could not be read, or ""
        self._saved = self.now

    @classmethod
    def load(cls, folder: Path) -> "Preferences":
        """Read the preferences in `folder`; `problem` says what could not be read."""
        path = folder / FILE_NAME
        if not os.path.exists(path):
            return cls(path=path)
        try:
            now, problem = _remembered(read_json(path))
        except InputError as error:
            now, problem = Remembered(), str(error)
        preferences = cls(now, path)
        if problem:
            preferences.problem = f"{problem} Its settings are reset."
            aside = path.with_suffix(".damaged.json")
            with suppress(OSError, InputError):  # one that is empty needs no copy, for example
                write_whole(aside, file_bytes(path), FOR_THE_USER)
                preferences.problem += f" The old ones are kept in {aside.name}."
        return preferences

    def saving(self) -> Callable[[], None] | None:
        """Return a function that writes the preferences as they are now; None if nothing changed.

        It may be called on a thread, in the order in which this method was called. It raises
        InputError, but only once, if nothing can be written.
        """
        if self.path is None or self.now == self._saved:
            return None
        before, self._saved = self._saved, self.now
        return partial(self._write, self.path, before, self.now)

    # Two windows may be open. Each wrote all of its preferences, so the last one won and the recent
    # files of the other were lost. Only what changed in this window is merged into the file as it
    # is now, under a lock.
    def _write(self, path: Path, before: Remembered, now: Remembered) -> None:
        """Write the changes since `before` to the file, which other windows write too."""
        if self.path is None:  # an earlier call has failed
            return
        try:
            path.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
            with locked(path.with_suffix(".lock")):
                with suppress(InputError):  # missing or damaged: write everything again
                    now = merged(_remembered(read_json(path))[0], before, now)
                text = json.dumps(record_to_json(now), indent=2) + "\n"
                write_whole(path, text.encode(), FOR_THE_USER)  # private: it names opened files
        except (OSError, InputError) as error:
            self.path = None
            raise InputError(f"Preferences cannot be saved: {error}") from error

    def first_view(self, given: ViewState) -> ViewState:
        """Return the given view state, with remembered values for fields that were not given."""
        if not given.display and not given.view:
            given = replace(given, display=self.now.display, view=self.now.view)
        usual, now = ViewState(), self.now
        remembered: Values = dict(unit=now.unit, guides=now.guides, peaking=now.peaking)
        left = {n: v for n, v in remembered.items() if getattr(given, n) == getattr(usual, n)}
        return replace(given, **left)

    def change(self, **changes: Any) -> None:
        """Change these fields."""
        self.now = replace(self.now, **changes)

    def opened(self, text: str) -> None:
        """Put an opened file first in the list of recent files."""
        self.change(recent=with_first((absolute(text),), self.now.recent))

    def looked_in(self, purpose: str, folder: Path) -> None:
        """Remember the folder in which a file was chosen."""
        self.change(folders={**self.now.folders, purpose: str(folder)})

    def options_for(self, text: str) -> PlateOptions:
        """Return the plate options that were chosen for the folder of a file or pattern.

        A near or far distance that the convention does not use would make plates unreadable; it is
        removed, and `problem` reports that.
        """
        path = absolute(text)
        folder = path if path in self.now.plates else os.path.dirname(path)
        options = self.now.plates.get(folder, PlateOptions())
        used = _without_unused_ends(options)
        if used != options:
            self.change(plates={**self.now.plates, folder: used})
            self.problem = (
                f"The near and far distances remembered for {folder} are forgotten: its depth is "
                f"read as {options.depth_convention}, which does not use them."
            )
        return used

    def read_so(self, folder: Path, options: PlateOptions) -> None:
        """Remember the plate options for a folder."""
        options = _without_unused_ends(
            replace(options, depth_source=None, depth_model=None, depth_known=None, behind=())
        )
        plates = {name: o for name, o in self.now.plates.items() if name != str(folder)}
        if options != PlateOptions():
            plates[str(folder)] = options
        self.change(plates=dict(list(plates.items())[-_FOLDERS_MAX:]))


def _without_unused_ends(options: PlateOptions) -> PlateOptions:
    """Return `options` without near and far if the depth convention does not use them."""
    if options.depth_convention.facts.takes_ends:
        return options
    return replace(options, near_m=None, far_m=None)


def _remembered(top: JsonEntry) -> tuple[Remembered, str]:
    """Return the preferences of the file, and a sentence about the first invalid entry, or "".

    Unknown entries, written by another version of the program, are ignored.
    """
    if not isinstance(top.value, dict):
        top.refuse("the file should be an object in braces.")
    values, problems = {}, []
    for name, hint in get_type_hints(Remembered).items():
        if name in top.value:
            try:
                entry = JsonEntry(top.path, name, top.value[name])
                values[name] = entry.of_type(hint)
                _check_limits(entry, values[name])
            except InputError as error:
                values.pop(name, None)
                problems.append(f"{error}.")
    return Remembered(**values), problems[0] if problems else ""


def _check_limits(entry: JsonEntry, value: object) -> None:
    """Refuse a number beyond its limits; also in a pair or in a map."""
    low, high = _LIMITS.get(entry.place, (-math.inf, math.inf))
    several = value.values() if isinstance(value, Mapping) else value
    for number in several if isinstance(several, Iterable) else (several,):
        if isinstance(number, int | float) and not low <= number <= high:
            entry.refuse(f"{number:g} should be {low:g} to {high:g}")


# The limits of numbers in the file.
_LIMITS = {
    "window_size": (WINDOW_LEAST, _WINDOW_MOST),
    "ui_scales": (SCALES[0], SCALES[-1]),
    "layout_em": (0, _EM_MOST),
    "memory_mb": (0, MEGABYTES_MOST),
    "disk_mb": (0, MEGABYTES_MOST),
}


Kept = TypeVar("Kept", bound="DataclassInstance")

RECENT_MAX = 10


def merged(theirs: Kept, before: Kept, now: Kept) -> Kept:
    """Return `theirs` with the changes from `before` to `now`.

    In maps and recent files, only changed entries are replaced; other fields change as a whole.
    """
    changed: dict[str, object] = {}
    for name in (one.name for one in fields(now)):
        old, new, other = (getattr(of, name) for of in (before, now, theirs))
        if name == "recent":
            changed[name] = with_first(_opened_since(old, new), other)
        elif isinstance(new, Mapping):
            changed[name] = _merged_map(other, old, new)
        elif new != old:
            changed[name] = new
    return replace(theirs, **changed)


def with_first(opened: tuple[str, ...], recent: tuple[str, ...]) -> tuple[str, ...]:
    """Return the recent files after these were opened, the latest first."""
    return tuple(dict.fromkeys([*opened, *recent]))[:RECENT_MAX]


def _opened_since(before: tuple[str, ...], now: tuple[str, ...]) -> tuple[str, ...]:
    """Return the shortest beginning of `now` that turns `before` into it."""
    beginnings = (now[:count] for count in range(len(now)))
    return next((opened for opened in beginnings if with_first(opened, before) == now), now)


def _merged_map(
    theirs: Mapping[str, object], before: Mapping[str, object], now: Mapping[str, object]
) -> dict[str, object]:
    changed = {name: value for name, value in now.items() if before.get(name) != value}
    touched = {*changed, *(name for name in before if name not in now)}
    return {name: value for name, value in theirs.items() if name not in touched} | changed

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
from heatlens.core.base.paths import absolute, read_file_bytes
from heatlens.core.model.curves.frames import Ending
from heatlens.core.model.option import Values
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.core.model.view.guides import NO_GUIDES, USUAL_PEAKING, Guides, Peaking
from heatlens.core.model.view.ui_sizes import SCALES
from heatlens.core.model.view.view import ViewState
from heatlens.deliver.farm.connection import SchedulerIdentity
from heatlens.deliver.farm.export_place import HERE, ExportPlace, LeftExport
from heatlens.media.files.atomic_file import FOR_THE_USER, write_atomically
from heatlens.media.files.file_lock import lock_file
from heatlens.media.files.json_record import JsonEntry, read_json, record_to_json
from heatlens.media.live.ring.channel_map import ChannelMap

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

FILE_NAME = "preferences.json"
_FOLDERS_MAX = 200  # largest number of folders whose plate options are remembered
_EM_MOST = 1000.0  # largest font size in pixels
MEGABYTES_MOST = 10**8  # largest limit for rendered frames, more than any disk has
WINDOW_LEAST, _WINDOW_MOST = 200, 16384  # limits of a side of the window, in screen units


class Theme(StrEnum):
    """The color theme of the interface."""

    DARK = "dark"
    LIGHT = "light"


@dataclass(frozen=True)
class PreferenceValues:
    """The preferences, as an immutable value.

    recent         absolute paths of opened files, the latest first
    folders        the last folder of each file dialog, by purpose
    plates         plate options by folder, the latest choice last
    display, view  names in the color config; "" for its defaults
    unit           unit of distances, "m" or "ft"
    guides         guide lines and mattes; the desqueeze is not remembered, each file has its own
    peaking        settings of the focus peaking
    window_size    in screen units; None if unknown
    is_maximized   whether the window was maximised
    hidden_panels  names of the closed panels
    layout         arrangement of the panels as ImGui writes it; "" for the original one
    layout_em      font size in pixels when the layout was written; 0 if unknown
    theme          the color theme of the interface
    ui_scales      the user's scale of the interface, by monitor
    knows_previews whether the user was told that a quick picture comes before the whole one
    feed_labels    whether the second window shows the names of looks in a grid
    ending         what happens after the last played frame
    every_frame    True if playback waits for each frame; False if it keeps time
    keep_frames    whether frames of a shot are rendered ahead while idle
    memory_mb      memory limit for rendered frames in MB; 0 for a quarter of the free memory
    ring_maps      which channels of a controller turn which rings of the lens
    disk_mb        disk limit for rendered frames in MB; 0 keeps none on disk
    export_place   who made the frames of the last export
    left_exports   exports that a cluster continues, by source
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
    knows_previews: bool = False
    feed_labels: bool = True
    ending: Ending = Ending.LOOP
    every_frame: bool = True
    keep_frames: bool = True
    memory_mb: int = 0
    disk_mb: int = 4000
    ring_maps: tuple[ChannelMap, ...] = ()
    export_place: ExportPlace = HERE
    left_exports: Mapping[str, LeftExport] = field(default_factory=dict)
    cluster: SchedulerIdentity | None = None


class Preferences:
    """The current preferences, saved to a file if a path is given."""

    def __init__(self, values: PreferenceValues | None = None, path: Path | None = None) -> None:
        """Keep preferences at `path`; None keeps them only as long as the program runs."""
        self.values = values or PreferenceValues()
        self.path = path
        self.problem = ""  # a sentence about entries of the file that could not be read, or ""
        self._saved_values = self.values

    @classmethod
    def load(cls, folder: Path) -> "Preferences":
        """Read the preferences in `folder`; `problem` is a sentence about what cannot be read."""
        path = folder / FILE_NAME
        if not os.path.exists(path):
            return cls(path=path)
        try:
            values, problem = _values_from_json(read_json(path))
        except InputError as error:
            values, problem = PreferenceValues(), str(error)
        preferences = cls(values, path)
        if problem:
            preferences.problem = f"{problem} Its settings are reset."
            copy_path = path.with_suffix(".damaged.json")
            with suppress(OSError, InputError):  # an empty file needs no copy, for example
                write_atomically(copy_path, read_file_bytes(path), FOR_THE_USER)
                preferences.problem += f" The old ones are kept in {copy_path.name}."
        return preferences

    def save_function(self) -> Callable[[], None] | None:
        """Return a function that writes the preferences as they are now; None if nothing changed.

        It may be called on a thread, in the order in which this method was called. It raises
        InputError, but only once, if nothing can be written.
        """
        if self.path is None or self.values == self._saved_values:
            return None
        old_values, self._saved_values = self._saved_values, self.values
        return partial(self._write, self.path, old_values, self.values)

    # Two windows may be open. Only the changes of this window are merged into the file as it is
    # now, under a lock. If each window wrote all of its preferences, the recent files of the other
    # window would be lost.
    def _write(
        self, path: Path, old_values: PreferenceValues, new_values: PreferenceValues
    ) -> None:
        """Write the changes since `old_values` to the file, which other windows write too."""
        if self.path is None:  # an earlier call has failed
            return
        try:
            path.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
            with lock_file(path.with_suffix(".lock")):
                with suppress(InputError):  # missing or damaged: write everything again
                    new_values = merge_changes(
                        _values_from_json(read_json(path))[0], old_values, new_values
                    )
                text = json.dumps(record_to_json(new_values), indent=2) + "\n"
                write_atomically(
                    path, text.encode(), FOR_THE_USER
                )  # private: it names opened files
        except (OSError, InputError) as error:
            self.path = None
            raise InputError(f"Preferences cannot be saved: {error}") from error

    def first_view(self, given_view: ViewState) -> ViewState:
        """Return the given view state, with remembered values for fields that were not given."""
        if not given_view.display and not given_view.view:
            given_view = replace(given_view, display=self.values.display, view=self.values.view)
        default_view, values = ViewState(), self.values
        remembered: Values = dict(unit=values.unit, guides=values.guides, peaking=values.peaking)
        filled = {
            name: value
            for name, value in remembered.items()
            if getattr(given_view, name) == getattr(default_view, name)
        }
        return replace(given_view, **filled)

    def change(self, **changes: Any) -> None:
        """Change these fields."""
        self.values = replace(self.values, **changes)

    def remember_opened(self, text: str) -> None:
        """Put an opened file first in the list of recent files."""
        self.change(recent=with_first((absolute(text),), self.values.recent))

    def forget_opened(self, text: str) -> None:
        """Remove a file from the list of recent files, because it could not be written."""
        self.change(recent=tuple(it for it in self.values.recent if it != absolute(text)))

    def remember_folder(self, purpose: str, folder: Path) -> None:
        """Remember the folder in which a file was chosen."""
        self.change(folders={**self.values.folders, purpose: str(folder)})

    def options_for(self, text: str) -> PlateOptions:
        """Return the plate options that were chosen for the folder of a file or pattern.

        A near or far distance that the convention does not use would make plates unreadable; it is
        removed, and `problem` reports that.
        """
        path = absolute(text)
        folder = path if path in self.values.plates else os.path.dirname(path)
        options = self.values.plates.get(folder, PlateOptions())
        used_options = _without_unused_ends(options)
        if used_options != options:
            self.change(plates={**self.values.plates, folder: used_options})
            self.problem = (
                f"The near and far distances remembered for {folder} are forgotten: its depth is "
                f"read as {options.depth_convention}, which does not use them."
            )
        return used_options

    def remember_options(self, folder: Path, options: PlateOptions) -> None:
        """Remember the plate options for a folder."""
        options = _without_unused_ends(
            replace(options, depth_source=None, depth_model=None, depth_known=None, behind=())
        )
        plates = {
            name: plate_options
            for name, plate_options in self.values.plates.items()
            if name != str(folder)
        }
        if options != PlateOptions():
            plates[str(folder)] = options
        self.change(plates=dict(list(plates.items())[-_FOLDERS_MAX:]))


def _without_unused_ends(options: PlateOptions) -> PlateOptions:
    """Return `options` without near and far if the depth convention does not use them."""
    if options.depth_convention.facts.takes_ends:
        return options
    return replace(options, near_m=None, far_m=None)


def _values_from_json(top: JsonEntry) -> tuple[PreferenceValues, str]:
    """Return the preferences of the file, and a sentence about the first invalid entry, or "".

    Unknown entries, written by another version of the program, are ignored.
    """
    if not isinstance(top.value, dict):
        top.refuse("the file should be an object in braces.")
    values, problems = {}, []
    for name, hint in get_type_hints(PreferenceValues).items():
        if name in top.value:
            try:
                entry = JsonEntry(top.path, place=name, value=top.value[name])
                values[name] = entry.convert(hint)
                _check_limits(entry, values[name])
            except InputError as error:
                values.pop(name, None)
                problems.append(f"{error}.")
    return PreferenceValues(**values), problems[0] if problems else ""


def _check_limits(entry: JsonEntry, value: object) -> None:
    """Refuse a number beyond its limits; also in a pair or in a map."""
    low, high = _LIMITS.get(entry.place, (-math.inf, math.inf))
    numbers = value.values() if isinstance(value, Mapping) else value
    for number in numbers if isinstance(numbers, Iterable) else (numbers,):
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


Record = TypeVar("Record", bound="DataclassInstance")

RECENT_MAX = 10


def merge_changes(file_values: Record, old_values: Record, new_values: Record) -> Record:
    """Return `file_values` with the changes from `old_values` to `new_values`.

    In maps and recent files, only changed entries are replaced; other fields change as a whole.
    """
    changes: dict[str, object] = {}
    for name in (field_info.name for field_info in fields(new_values)):
        old_value, new_value, file_value = (
            getattr(values, name) for values in (old_values, new_values, file_values)
        )
        if name == "recent":
            changes[name] = with_first(_newly_opened(old_value, new_value), file_value)
        elif isinstance(new_value, Mapping):
            changes[name] = _merge_map(file_value, old_value, new_value)
        elif new_value != old_value:
            changes[name] = new_value
    return replace(file_values, **changes)


def with_first(opened_files: tuple[str, ...], recent: tuple[str, ...]) -> tuple[str, ...]:
    """Return the recent files after these were opened, the latest first."""
    return tuple(dict.fromkeys([*opened_files, *recent]))[:RECENT_MAX]


def _newly_opened(old_recent: tuple[str, ...], new_recent: tuple[str, ...]) -> tuple[str, ...]:
    """Return the files that were opened to turn `old_recent` into `new_recent`, latest first."""
    beginnings = (new_recent[:count] for count in range(len(new_recent)))
    return next(
        (
            opened_files
            for opened_files in beginnings
            if with_first(opened_files, old_recent) == new_recent
        ),
        new_recent,
    )


def _merge_map(
    file_map: Mapping[str, object], old_map: Mapping[str, object], new_map: Mapping[str, object]
) -> dict[str, object]:
    """Return `file_map` with the entries that differ between `old_map` and `new_map` changed."""
    changed_entries = {name: value for name, value in new_map.items() if old_map.get(name) != value}
    changed_names = {*changed_entries, *(name for name in old_map if name not in new_map)}
    return {
        name: value for name, value in file_map.items() if name not in changed_names
    } | changed_entries

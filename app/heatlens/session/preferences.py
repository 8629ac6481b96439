"""What the program remembers of its user from one start to the next."""

import json
import os
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, field, replace
from enum import StrEnum
from pathlib import Path
from typing import Any

from heatlens.errors import InputError
from heatlens.files.atomic_file import FOR_THE_USER, write_whole
from heatlens.files.json_record import JsonEntry, read_json, record_to_json
from heatlens.model.guides import NO_GUIDES, Guides
from heatlens.model.peaking import USUAL_PEAKING, Peaking
from heatlens.model.plate_options import PlateOptions
from heatlens.model.view import ViewState
from heatlens.ring.channel_map import ChannelMap
from heatlens.session.playback import Ending
from heatlens.session.ui_sizes import SCALES

FILE_NAME = "preferences.json"
RECENT_MAX = 10
_FOLDERS_MAX = 200  # of which it is known how their plates are read
_EM_MOST = 1000.0  # pixels
MEGABYTES_MOST = 10**8  # for rendered frames: more than any disk has
WINDOW_LEAST, _WINDOW_MOST = 200, 16384  # screen units a side


class Theme(StrEnum):
    """The colours that the interface is drawn in."""

    DARK = "dark"
    LIGHT = "light"


@dataclass(frozen=True)
class Remembered:
    """The preferences as a value.

    recent         what was opened, the latest first, absolute
    folders        where files were looked for last, by the purpose
    plates         how the plates of a folder are read, by the folder, the latest choice last
    display, view  names in the colour config; "" its defaults
    unit           distances in "m" or "ft"
    guides         lines and mattes over the picture; how wide pixels are is told by each file
    peaking        how what is in focus is coloured, once that is asked for
    window_size    in screen units, None: not known
    is_maximized   whether the window filled the screen
    hidden_panels  panels that were closed
    layout         where the panels lie, as ImGui writes it; "" where they lie in the beginning
    layout_em      height of the letters in pixels when that was written; 0: not known
    theme          the colours of the interface
    ui_scales      how much larger than usual the interface is drawn, by the screen
    feed_labels    whether looks beside each other are named in the second window
    ending         what happens after the last frame that is played
    every_frame    whether playing waits for each frame to be there; else it keeps time
    keep_frames    whether frames of a shot are rendered ahead while nothing else is to do
    memory_mb      for rendered frames, in millions of bytes; 0: a quarter of what is free
    ring_maps      which channels of a controller turn the rings of the lens
    disk_mb        for rendered frames, in millions of bytes; 0: none are kept on disk
    """

    recent: tuple[str, ...] = ()
    folders: Mapping[str, str] = field(default_factory=dict)
    plates: Mapping[str, PlateOptions] = field(default_factory=dict)
    display: str = ""
    view: str = ""
    unit: str = "m"
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


class Preferences:
    """Remembers, and writes what it remembers to a file where it was given one."""

    def __init__(self, now: Remembered | None = None, path: Path | None = None) -> None:
        """Keep preferences at `path`; None keeps them only as long as the program runs."""
        self.now = now or Remembered()
        self.path = path
        self.problem = ""  # what could not be read of the file, in a sentence
        self._saved = self.now

    @classmethod
    def load(cls, folder: Path) -> "Preferences":
        """Read the preferences in `folder`; `problem` says what of them cannot be read."""
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
            with suppress(OSError):  # a copy for whoever wrote in it; without one nothing is worse
                path.with_suffix(".damaged.json").write_bytes(path.read_bytes())
        return preferences

    def save(self) -> None:
        """Write what has changed since. Raises InputError, once, where that is not possible."""
        if self.path is None or self.now == self._saved:
            return
        path, self._saved = self.path, self.now
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            text = json.dumps(_entries(self.now), indent=2) + "\n"
            write_whole(path, text.encode(), FOR_THE_USER)  # it names what was opened
        except (OSError, InputError) as error:
            self.path = None
            raise InputError(f"Preferences are not kept: {error}") from error

    def first_view(self, given: ViewState) -> ViewState:
        """Return `given`, and where it says nothing what is remembered."""
        if not given.display and not given.view:
            given = replace(given, display=self.now.display, view=self.now.view)
        usual, now = ViewState(), self.now
        remembered: dict[str, Any] = dict(unit=now.unit, guides=now.guides, peaking=now.peaking)
        left = {n: v for n, v in remembered.items() if getattr(given, n) == getattr(usual, n)}
        return replace(given, **left)

    def change(self, **changes: Any) -> None:
        """Remember other values of these fields."""
        self.now = replace(self.now, **changes)

    def opened(self, text: str) -> None:
        """Let this lead the recent files: it was opened."""
        recent = dict.fromkeys([absolute(text), *self.now.recent])
        self.change(recent=tuple(recent)[:RECENT_MAX])

    def looked_in(self, purpose: str, folder: Path) -> None:
        """Remember where a file was chosen."""
        self.change(folders={**self.now.folders, purpose: str(folder)})

    def options_for(self, text: str) -> PlateOptions:
        """Return how a file, pattern or folder is read, as was chosen for its folder.

        Ends of a depth that has none are dropped for good, which `problem` tells: plates that are
        read as distances would be refused with them.
        """
        path = absolute(text)
        folder = path if path in self.now.plates else os.path.dirname(path)
        options = self.now.plates.get(folder, PlateOptions())
        kept = _without_unused_ends(options)
        if kept != options:
            self.change(plates={**self.now.plates, folder: kept})
            self.problem = (
                f"The near and far ends remembered for {folder} are forgotten: its depth is read "
                f"as {options.depth_convention}, which has none."
            )
        return kept

    def read_so(self, folder: Path, options: PlateOptions) -> None:
        """Remember how the plates of a folder are read; each has a depth of its own."""
        options = _without_unused_ends(replace(options, depth_source=None, behind=()))
        plates = {name: o for name, o in self.now.plates.items() if name != str(folder)}
        if options != PlateOptions():
            plates[str(folder)] = options
        self.change(plates=dict(list(plates.items())[-_FOLDERS_MAX:]))


def _without_unused_ends(options: PlateOptions) -> PlateOptions:
    """Return `options` without near and far where the depth convention has no ends."""
    if options.depth_convention.facts.takes_ends:
        return options
    return replace(options, near_m=None, far_m=None)


def absolute(text: str) -> str:
    """Return a path or a pattern from the root on, links as they are."""
    return os.path.abspath(os.path.expanduser(text))


def _entries(now: Remembered) -> dict[str, Any]:
    """Return the preferences as JSON has them."""
    plates = {folder: record_to_json(options) for folder, options in now.plates.items()}
    entries = {name: getattr(now, name) for name in _READERS}
    entries["ring_maps"] = [record_to_json(found) for found in now.ring_maps]
    entries["guides"], entries["peaking"] = record_to_json(now.guides), record_to_json(now.peaking)
    maps = {"folders": dict(now.folders), "ui_scales": dict(now.ui_scales)}
    return entries | {"plates": plates} | maps


def _remembered(top: JsonEntry) -> tuple[Remembered, str]:
    """Return what the file says, and the first thing in it that cannot be read, or "".

    Entries of another version of the program are left alone.
    """
    if not isinstance(top.value, dict):
        top.refuse("the file should be an object in braces.")
    values, problems = {}, []
    for name, read in _READERS.items():
        if name in top.value:
            try:
                values[name] = read(JsonEntry(top.path, name, top.value[name]))
            except InputError as error:
                problems.append(f"{error}.")
    return Remembered(**values), problems[0] if problems else ""


def _text_map(entry: JsonEntry) -> dict[str, str]:
    return {name: member.text() for name, member in _open_members(entry).items()}


def _plates(entry: JsonEntry) -> dict[str, PlateOptions]:
    return {name: member.record(PlateOptions) for name, member in _open_members(entry).items()}


def _open_members(entry: JsonEntry) -> dict[str, JsonEntry]:
    """Return the members of an object whose names may be any."""
    return entry.members(list(entry.value) if isinstance(entry.value, dict) else ())


def _scales(entry: JsonEntry) -> dict[str, float]:
    scales = {name: member.number() for name, member in _open_members(entry).items()}
    if any(not SCALES[0] <= scale <= SCALES[-1] for scale in scales.values()):
        entry.refuse(f"scales should be {SCALES[0]} to {SCALES[-1]}")
    return scales


def _em(entry: JsonEntry) -> float:
    em = entry.number()
    if not 0 <= em <= _EM_MOST:
        entry.refuse(f"{em} should be 0 to {_EM_MOST} pixels")
    return em


def _texts(entry: JsonEntry) -> tuple[str, ...]:
    return tuple(item.text() for item in entry.items())


def _window_size(entry: JsonEntry) -> tuple[int, int] | None:
    if entry.value is None:
        return None
    sides = tuple(item.whole() for item in entry.items())
    if len(sides) != 2 or not all(WINDOW_LEAST <= side <= _WINDOW_MOST for side in sides):
        entry.refuse(f"{list(sides)} should be a width and a height")
    return sides[0], sides[1]


def _ring_maps(entry: JsonEntry) -> tuple[ChannelMap, ...]:
    return tuple(item.record(ChannelMap) for item in entry.items())


def _flag(entry: JsonEntry) -> bool:
    if not isinstance(entry.value, bool):
        entry.refuse(f"{entry.value!r} should be true or false")
    return bool(entry.value)


def _megabytes(entry: JsonEntry) -> int:
    count = entry.whole()
    if not 0 <= count <= MEGABYTES_MOST:
        entry.refuse(f"{count} should be 0 to {MEGABYTES_MOST}")
    return count


_READERS = {
    "recent": _texts,
    "folders": _text_map,
    "plates": _plates,
    "display": JsonEntry.text,
    "view": JsonEntry.text,
    "unit": lambda entry: entry.choice(("m", "ft")),
    "guides": lambda entry: entry.record(Guides),
    "peaking": lambda entry: entry.record(Peaking),
    "window_size": _window_size,
    "is_maximized": _flag,
    "hidden_panels": _texts,
    "layout": JsonEntry.text,
    "layout_em": _em,
    "theme": lambda entry: Theme(entry.choice(tuple(Theme))),
    "ui_scales": _scales,
    "feed_labels": _flag,
    "ending": lambda entry: Ending(entry.choice(tuple(Ending))),
    "every_frame": _flag,
    "keep_frames": _flag,
    "memory_mb": _megabytes,
    "disk_mb": _megabytes,
    "ring_maps": _ring_maps,
}

"""Reload changed shader files into the running program, for development of shaders.

With HEATLENS_RELOAD_SHADERS=1 in the environment, every program is registered here, and
`ShaderReload.poll` rebuilds those whose files have changed. If a build fails, the old program stays
in use. Without the variable, this costs nothing. `rebuild_used` builds all anew that were used.
"""

import os
import time
import weakref
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

from heatlens.core.base.errors import ShaderError
from heatlens.core.base.paths import data_dir

VARIABLE = "HEATLENS_RELOAD_SHADERS"
EVERY_S = 0.5  # interval between two checks of the files


class Rebuildable(Protocol):
    """A program that can be built again from its files."""

    @property
    def files(self) -> frozenset[str]:
        """The files that its text came from, relative to the folder of shaders."""

    def rebuild(self) -> None:
        """Build from the current files; raise ShaderError and keep the old build on failure."""


_watched: "weakref.WeakSet[Rebuildable]" = weakref.WeakSet()


def is_on() -> bool:
    """Return whether shaders are to be reloaded."""
    return bool(os.environ.get(VARIABLE))


def watch(program: Rebuildable) -> None:
    """Rebuild `program` when its files change; only a weak reference to it is kept."""
    if is_on():
        _watched.add(program)


def rebuild_used() -> None:
    """Build all registered programs again that were built before."""
    for program in [program for program in _watched if program.files]:
        program.rebuild()


@dataclass(frozen=True)
class Reloaded:
    """The result of a reload: how many programs were rebuilt, and a message for the user."""

    programs: int
    message: str


class ShaderReload:
    """Checks the modification times of the shader files, at most twice a second."""

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._checked_at = clock()
        self._times = _file_times(data_dir("shaders"))

    def poll(self) -> Reloaded | None:
        """Rebuild programs of changed files, now and then; return None if none has changed."""
        if self._clock() - self._checked_at < EVERY_S:
            return None
        self._checked_at, previous_times = self._clock(), self._times
        self._times = _file_times(data_dir("shaders"))
        changed = {
            name for name, time_ns in self._times.items() if previous_times.get(name) != time_ns
        }
        users = [program for program in _watched if changed & program.files]
        return _rebuild_all(users, sorted(changed)) if users else None


def _rebuild_all(programs: Iterable[Rebuildable], changed: list[str]) -> Reloaded:
    """Rebuild programs, and report the first mistake, which the others probably share."""
    count, mistake = 0, ""
    for program in programs:
        try:
            program.rebuild()
            count += 1
        except ShaderError as error:
            mistake = mistake or " ".join(str(error).split())
    if mistake:
        return Reloaded(count, f"The last shaders that worked stay in use. {mistake}")
    return Reloaded(count, f"Reloaded {', '.join(changed)}: {count} programs were built again.")


def _file_times(folder: Path) -> dict[str, int]:
    """Return the modification time of each shader file in ns; skip files being replaced."""
    times: dict[str, int] = {}
    for path in folder.rglob("*.glsl"):
        try:
            times[path.relative_to(folder).as_posix()] = path.stat().st_mtime_ns
        except FileNotFoundError:
            continue
    return times

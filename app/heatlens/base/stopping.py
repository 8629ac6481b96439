"""Record unfinished files, so that the parent process can remove them after Ctrl-C.

`commands.launch` runs the command in a second process and kills that one when Ctrl-C is pressed. It
then removes the files recorded here. In a program that imports heatlens there is no such parent,
and these functions do nothing.

The record is a file in memory which both processes share. Its entries begin with a sign and end
with a zero byte, and are so short that a killed process cannot leave a partial one.
"""

import os
import signal
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from functools import cache
from pathlib import Path

_UNFINISHED, _FINISHED, _MADE, _HEARS, _DEAF, _SAID = b"+", b"-", b"?", b"h", b"d", b"s"

_DIE_WITH_PARENT = 1  # PR_SET_PDEATHSIG of prctl(2)

_record: int | None = None  # file descriptor, if a parent waits for this process


class Stopped(KeyboardInterrupt):
    """A stop signal was handled completely, and nothing is left to do."""

    def __init__(self, number: int) -> None:
        """Keep the `number` of the signal."""
        super().__init__()
        self.number = number


@cache
def stop_signals() -> frozenset[signal.Signals]:
    """Return the signals that end the program, except those it was started to ignore.

    `nohup` and shell scripts make programs ignore some signals, and worker processes inherit this.
    """
    names = ("SIGINT", "SIGTERM", "SIGHUP")  # Windows has no SIGHUP
    found = {getattr(signal, name) for name in names if hasattr(signal, name)}
    return frozenset(stop for stop in found if signal.getsignal(stop) is not signal.SIG_IGN)


@dataclass(frozen=True)
class Left:
    """The files that an ended process left behind."""

    unfinished: tuple[Path, ...]  # unfinished files and folders
    folders_made: tuple[Path, ...]  # new folders, to be removed if they are empty
    hears: bool  # the process handled Ctrl-C itself
    has_said: bool = False  # the process has printed that it was stopped


def begin_record() -> int:
    """Create the record that this process and its children share; return its descriptor."""
    global _record
    _record = os.memfd_create("heatlens")
    return _record


@contextmanager
def unfinished(path: str | os.PathLike[str]) -> Iterator[None]:
    """Mark the file or folder at `path` for removal if the process is killed inside the block."""
    _write(_UNFINISHED, path)
    try:
        yield
    finally:
        _write(_FINISHED, path)


@contextmanager
def temporary_folder() -> Iterator[Path]:
    """Yield a new temporary folder, which is removed however the block ends."""
    import shutil
    import tempfile

    path = Path(tempfile.gettempdir()) / f"heatlens-{os.urandom(8).hex()}"
    with unfinished(path):
        path.mkdir(mode=0o700)
        try:
            yield path
        finally:
            shutil.rmtree(path, ignore_errors=True)


def end_with(parent: int) -> None:
    """Let the system kill this process when its `parent` ends; this works only on Linux."""
    if sys.platform != "linux":
        return
    import ctypes

    ctypes.CDLL(None).prctl(_DIE_WITH_PARENT, signal.SIGKILL)
    if os.getppid() != parent:  # the parent had already ended
        os._exit(128 + signal.SIGKILL)


def folder_made(path: str | os.PathLike[str]) -> None:
    """Mark the folder `path` for removal after a stopped process, if it is empty."""
    _write(_MADE, path)


@contextmanager
def hearing() -> Iterator[None]:
    """Ask to receive stop signals inside the block, because this process ends itself cleanly."""
    _write(_HEARS)
    try:
        yield
    finally:
        _write(_DEAF)


def stop_was_said() -> None:
    """Record that this process has printed that it was stopped, so that its parent does not."""
    _write(_SAID)


def read_record(record: int) -> Left:
    """Read the record of a process that may have been killed."""
    unfinished_now: dict[str, None] = {}
    made: dict[str, None] = {}
    hears = has_said = False
    for entry in os.pread(record, os.fstat(record).st_size, 0).split(b"\0")[:-1]:
        sign, path = entry[:1], os.fsdecode(entry[1:])
        if sign == _UNFINISHED:
            unfinished_now[path] = None
        elif sign == _FINISHED:
            unfinished_now.pop(path, None)
        elif sign == _MADE:
            made[path] = None
        elif sign == _SAID:
            has_said = True
        else:
            hears = sign == _HEARS
    return Left(tuple(map(Path, unfinished_now)), tuple(map(Path, made)), hears, has_said)


def remove_left(left: Left) -> None:
    """Remove unfinished files, and new folders that are still empty."""
    import shutil  # imported here, so that the waiting process starts quickly

    for path in left.unfinished:
        if path.is_dir() and not path.is_symlink():
            shutil.rmtree(path, ignore_errors=True)
        else:
            with suppress(OSError):  # already gone, or renamed to its final name
                path.unlink()
    for folder in reversed(left.folders_made):
        with suppress(OSError):  # the folder is not empty, and stays
            folder.rmdir()


def _write(sign: bytes, path: str | os.PathLike[str] = "") -> None:
    if _record is not None:
        where = os.path.abspath(path) if path else ""
        os.write(_record, sign + os.fsencode(where) + b"\0")

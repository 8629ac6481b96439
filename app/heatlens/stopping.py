"""What a command tells the process that waits for it, in case it is stopped.

`commands.launch` does the work in a second process and ends that one when Ctrl-C is pressed. It
then removes what is written down here. In a program that imports heatlens nobody waits, and these
functions do nothing.

The record is a file in memory which both processes hold: entries that begin with a sign and end
with a zero byte. A process that is killed cannot leave a half-written entry of this size.
"""

import os
import signal
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path

_UNFINISHED, _FINISHED, _MADE, _HEARS, _DEAF, _SAID = b"+", b"-", b"?", b"h", b"d", b"s"

_DIE_WITH_PARENT = 1  # PR_SET_PDEATHSIG of prctl(2)

_record: int | None = None  # file descriptor, where a process waits for this one


class Stopped(KeyboardInterrupt):
    """A stop signal was answered in order; nothing is to be done any more."""

    def __init__(self, number: int) -> None:
        """Keep the `number` of the signal."""
        super().__init__()
        self.number = number


@dataclass(frozen=True)
class Left:
    """The files that a process that has ended left behind."""

    unfinished: tuple[Path, ...]  # files and folders that nobody will finish
    folders_made: tuple[Path, ...]  # to be removed where they are empty
    hears: bool  # the process answered Ctrl-C itself
    has_said: bool = False  # that it was stopped; it may have been killed while it ended


def begin_record() -> int:
    """Begin the record that this process and its children share; returns its descriptor."""
    global _record
    _record = os.memfd_create("heatlens")
    return _record


@contextmanager
def unfinished(path: str | os.PathLike[str]) -> Iterator[None]:
    """Have the file or folder at `path` removed if the process is ended inside the block."""
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
    """Have the system end this process when `parent`, which waits for it, ends. Linux alone can."""
    if sys.platform != "linux":
        return
    import ctypes

    ctypes.CDLL(None).prctl(_DIE_WITH_PARENT, signal.SIGKILL)
    if os.getppid() != parent:  # it ended before that was asked for
        os._exit(128 + signal.SIGKILL)


def folder_made(path: str | os.PathLike[str]) -> None:
    """Have the folder `path` removed at the end of a stopped process, if it is empty."""
    _write(_MADE, path)


@contextmanager
def hearing() -> Iterator[None]:
    """Have stop signals passed on to this process, which ends itself in order."""
    _write(_HEARS)
    try:
        yield
    finally:
        _write(_DEAF)


def stop_was_said() -> None:
    """Have the process that waits not say once more that this one was stopped."""
    _write(_SAID)


def read_record(record: int) -> Left:
    """Read what was written down by a process that may have been killed."""
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
    """Remove what is unfinished, and the folders made for it that stayed empty."""
    import shutil  # here: the process that waits is to be there at once

    for path in left.unfinished:
        if path.is_dir() and not path.is_symlink():
            shutil.rmtree(path, ignore_errors=True)
        else:
            with suppress(OSError):  # gone already, or renamed to its last name
                path.unlink()
    for folder in reversed(left.folders_made):
        with suppress(OSError):  # something is in it, which stays
            folder.rmdir()


def _write(sign: bytes, path: str | os.PathLike[str] = "") -> None:
    if _record is not None:
        where = os.path.abspath(path) if path else ""
        os.write(_record, sign + os.fsencode(where) + b"\0")

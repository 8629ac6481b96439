"""Record unfinished files, so that the parent process can remove them after Ctrl-C.

`commands.launch` runs the command in a second process and kills that one when Ctrl-C is pressed. It
then removes the files recorded here. In a program that imports heatlens there is no such parent,
and the functions of the record do nothing.

The record is a file in memory which both processes share. Its entries begin with a sign and end
with a zero byte, and are so short that a killed process cannot leave a partial one.

Loops note Ctrl-C, SIGTERM and a closed terminal, to end in an orderly way. While a loop sleeps in
GLFW it is in a C function, where Python runs no signal handlers. Python's own C handler still
writes a byte into a pipe at once; a thread that reads it wakes the loop.
"""

import os
import signal
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import cache
from pathlib import Path
from types import FrameType, TracebackType
from typing import Any, NamedTuple

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
    known = {getattr(signal, name) for name in names if hasattr(signal, name)}
    return frozenset(stop for stop in known if signal.getsignal(stop) is not signal.SIG_IGN)


class Left(NamedTuple):
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


class StopSignals:
    """A context manager that records stop signals, so that none interrupts unfinished work."""

    def __init__(self, wake: Callable[[], None]) -> None:
        """Create it; `wake` is called on a thread after each signal."""
        self.number: int | None = None  # the signal that was received
        self._wake = wake
        self._before: dict[signal.Signals, Any] = {}
        self._hearing = hearing()

    def __enter__(self) -> "StopSignals":
        """Begin to listen; call this on the main thread."""
        for number in stop_signals():
            self._before[number] = signal.signal(number, self._note)
        read, self._write = os.pipe()
        os.set_blocking(self._write, False)
        self._pipe_before = signal.set_wakeup_fd(self._write, warn_on_full_buffer=False)
        threading.Thread(target=self._follow, args=(read,), daemon=True).start()
        self._hearing.__enter__()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Restore the previous signal handlers."""
        self._hearing.__exit__(kind, error, trace)
        signal.set_wakeup_fd(self._pipe_before)
        os.close(self._write)
        for number, before in self._before.items():
            signal.signal(number, before)

    def raise_if_stopped(self) -> None:
        """Raise Stopped if a signal has been received."""
        if self.number is not None:
            raise Stopped(self.number)

    def _note(self, number: int, _frame: FrameType | None) -> None:
        self.number = number

    def _follow(self, pipe: int) -> None:
        """Wake the loop for each byte until the pipe is closed; runs on a thread."""
        while os.read(pipe, 1):
            self._wake()
        os.close(pipe)


@contextmanager
def uninterrupted() -> Iterator[None]:
    """Handle Ctrl-C after the block instead of inside it.

    moderngl builds programs in C and calls Python from there. It does not check for a
    KeyboardInterrupt raised in such a call, and the process crashes. This is for notebooks and
    programs that import heatlens; commands handle Ctrl-C in another way (`commands.launch`).
    """
    before = signal.getsignal(signal.SIGINT)
    # Only the main thread handles signals. None means a handler that was not set by Python.
    if threading.current_thread() is not threading.main_thread() or before is None:
        yield
        return
    arrived: list[FrameType | None] = []
    signal.signal(signal.SIGINT, lambda _number, frame: arrived.append(frame))
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)
        if arrived and callable(before):
            before(signal.SIGINT, arrived[0])

"""Record unfinished files, so that the parent process can remove them after Ctrl-C.

`commands.launch` runs the command in a second process and kills that one when Ctrl-C is pressed. It
then removes the files recorded here. That needs Linux: elsewhere the process removes them itself
before it ends. In a program that imports heatlens nobody keeps a record, and its functions do
nothing.

The entries of the record begin with a sign and end with a zero byte, and are so short that a killed
process cannot leave a partial one.

Loops note Ctrl-C, SIGTERM and a closed terminal, to end in an orderly way. While a loop sleeps in
GLFW it is in a C function, where Python runs no signal handlers. Python's own C handler still
writes a byte into a socket at once; a thread that reads it wakes the loop.
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
from typing import TYPE_CHECKING, Any, NamedTuple

if TYPE_CHECKING:
    import socket

# The signs of entries: of a path, or of the state of this process.
_UNFINISHED = b"+"
_FINISHED = b"-"
_FOLDER_CREATED = b"?"
_HANDLES_SIGNALS = b"h"
_LEAVES_SIGNALS = b"d"
_STOP_REPORTED = b"s"

_DIE_WITH_PARENT = 1  # PR_SET_PDEATHSIG of prctl(2)

_write_entry: Callable[[bytes], object] | None = None  # appends to the record, if there is one


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
    # A terminal that is closed sends SIGHUP, and on Windows SIGBREAK.
    names = ("SIGINT", "SIGTERM", "SIGHUP", "SIGBREAK")
    available = {getattr(signal, name) for name in names if hasattr(signal, name)}
    return frozenset(stop for stop in available if signal.getsignal(stop) is not signal.SIG_IGN)


class LeftoverFiles(NamedTuple):
    """The files that an ended process left behind."""

    unfinished: tuple[Path, ...]  # unfinished files and folders
    new_folders: tuple[Path, ...]  # new folders, to be removed if they are empty
    handles_signals: bool  # the process handled Ctrl-C itself
    has_reported_stop: bool = False  # the process has printed that it was stopped


def begin_record(write_entry: Callable[[bytes], object] | None) -> None:
    """Hand every entry of this process to `write_entry` from now on, or to nobody for None."""
    global _write_entry
    _write_entry = write_entry


@contextmanager
def mark_unfinished(path: str | os.PathLike[str]) -> Iterator[None]:
    """Mark the file or folder at `path` for removal if the process is killed inside the block."""
    _append_entry(_UNFINISHED, path)
    try:
        yield
    finally:
        _append_entry(_FINISHED, path)


@contextmanager
def temporary_folder() -> Iterator[Path]:
    """Yield a new temporary folder, which is removed however the block ends."""
    import shutil
    import tempfile

    path = Path(tempfile.gettempdir()) / f"heatlens-{os.urandom(8).hex()}"
    with mark_unfinished(path):
        path.mkdir(mode=0o700)
        try:
            yield path
        finally:
            shutil.rmtree(path, ignore_errors=True)


_LOWER_BY = 15


def die_with_parent(parent: int) -> None:
    """Let this process end when its `parent`, a process number, ends; macOS has no way."""
    if sys.platform == "win32":
        from heatlens.core.base.windows_calls import wait_for_process

        def end_with_parent() -> None:
            wait_for_process(parent)
            os._exit(128 + signal.SIGTERM)

        threading.Thread(target=end_with_parent, daemon=True).start()
        return
    if sys.platform != "linux":
        return
    import ctypes

    ctypes.CDLL(None).prctl(_DIE_WITH_PARENT, signal.SIGKILL)
    if os.getppid() != parent:  # the parent had already ended
        os._exit(128 + signal.SIGKILL)


def lower_priority(process: int = 0) -> None:
    """Let others go before a process, by default this one; on Windows, its start does that."""
    if sys.platform != "win32":
        priority = os.getpriority(os.PRIO_PROCESS, process)
        os.setpriority(os.PRIO_PROCESS, process, priority + _LOWER_BY)


def record_new_folder(path: str | os.PathLike[str]) -> None:
    """Record the new folder `path`.

    It is removed if this process is stopped and the folder is still empty.
    """
    _append_entry(_FOLDER_CREATED, path)


@contextmanager
def handle_own_signals() -> Iterator[None]:
    """Ask to receive stop signals inside the block, because this process ends itself cleanly."""
    _append_entry(_HANDLES_SIGNALS)
    try:
        yield
    finally:
        _append_entry(_LEAVES_SIGNALS)


def record_stop_reported() -> None:
    """Record that this process has printed that it was stopped, so that its parent does not."""
    _append_entry(_STOP_REPORTED)


def read_record(record: bytes) -> LeftoverFiles:
    """Return what the record of a process, which may have been killed, says about its files."""
    unfinished_paths: dict[str, None] = {}
    new_folders: dict[str, None] = {}
    handles_signals = has_reported_stop = False
    for entry in record.split(b"\0")[:-1]:
        sign, path = entry[:1], os.fsdecode(entry[1:])
        if sign == _UNFINISHED:
            unfinished_paths[path] = None
        elif sign == _FINISHED:
            unfinished_paths.pop(path, None)
        elif sign == _FOLDER_CREATED:
            new_folders[path] = None
        elif sign == _STOP_REPORTED:
            has_reported_stop = True
        else:
            handles_signals = sign == _HANDLES_SIGNALS
    return LeftoverFiles(
        unfinished=tuple(map(Path, unfinished_paths)),
        new_folders=tuple(map(Path, new_folders)),
        handles_signals=handles_signals,
        has_reported_stop=has_reported_stop,
    )


def remove_leftovers(leftovers: LeftoverFiles) -> None:
    """Remove unfinished files, and new folders that are still empty."""
    import shutil  # imported here, so that the waiting process starts quickly

    for path in leftovers.unfinished:
        if path.is_dir() and not path.is_symlink():
            shutil.rmtree(path, ignore_errors=True)
        else:
            with suppress(OSError):  # already gone, or renamed to its final name
                path.unlink()
    for folder in reversed(leftovers.new_folders):
        with suppress(OSError):  # the folder is not empty, and stays
            folder.rmdir()


def _append_entry(sign: bytes, path: str | os.PathLike[str] = "") -> None:
    """Append an entry to the record, if there is one."""
    if _write_entry is not None:
        absolute_path = os.path.abspath(path) if path else ""
        _write_entry(sign + os.fsencode(absolute_path) + b"\0")


class StopSignals:
    """A context manager that records stop signals, so that none interrupts unfinished work."""

    def __init__(self, wake: Callable[[], None]) -> None:
        """Create it; `wake` is called on a thread after each signal."""
        self.number: int | None = None  # the signal that was received
        self._wake = wake
        self._previous_handlers: dict[signal.Signals, Any] = {}
        self._own_signals = handle_own_signals()

    def __enter__(self) -> "StopSignals":
        """Begin to record stop signals; call this on the main thread, as Python requires."""
        import socket  # here, as it takes 6 ms that most commands need not wait for

        for number in stop_signals():
            self._previous_handlers[number] = signal.signal(number, self._record_signal)
        byte_output, self._byte_input = socket.socketpair()
        self._byte_input.setblocking(False)
        descriptor = self._byte_input.fileno()
        self._previous_wakeup_fd = signal.set_wakeup_fd(descriptor, warn_on_full_buffer=False)
        threading.Thread(target=self._wake_per_byte, args=(byte_output,), daemon=True).start()
        self._own_signals.__enter__()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Restore the previous signal handlers."""
        self._own_signals.__exit__(kind, error, trace)
        signal.set_wakeup_fd(self._previous_wakeup_fd)
        self._byte_input.close()
        for number, previous_handler in self._previous_handlers.items():
            signal.signal(number, previous_handler)

    def raise_if_stopped(self) -> None:
        """Raise Stopped if a signal has been received."""
        if self.number is not None:
            raise Stopped(self.number)

    def _record_signal(self, number: int, _frame: FrameType | None) -> None:
        self.number = number

    def _wake_per_byte(self, byte_output: "socket.socket") -> None:
        """Wake the loop for each byte until the other end is closed; runs on a thread."""
        with byte_output:
            while byte_output.recv(1):
                self._wake()


@contextmanager
def delay_interrupts() -> Iterator[None]:
    """Handle Ctrl-C after the block instead of inside it.

    moderngl makes programs and contexts in C and calls Python from there. It does not check for a
    KeyboardInterrupt raised in such a call: the process crashes, or the Ctrl-C is lost. This is for
    notebooks, for programs that import heatlens, and for commands on systems other than Linux. On
    Linux, commands handle Ctrl-C in another way (`commands.launch`).
    """
    previous_handler = signal.getsignal(signal.SIGINT)
    # Only the main thread handles signals. None means a handler that was not set by Python.
    if threading.current_thread() is not threading.main_thread() or previous_handler is None:
        yield
        return
    delayed_frames: list[FrameType | None] = []
    signal.signal(signal.SIGINT, lambda _number, frame: delayed_frames.append(frame))
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, previous_handler)
        if delayed_frames and callable(previous_handler):
            previous_handler(signal.SIGINT, delayed_frames[0])

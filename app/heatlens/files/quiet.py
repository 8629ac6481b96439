"""Keep the OpenEXR library's own words off the terminal: each failure has one sentence, ours."""

import contextlib
import ctypes
import io
import os
import sys
import threading
from collections.abc import Iterator
from contextlib import ExitStack
from typing import Any, TextIO


class _Depth(threading.local):
    """How many quiet blocks the present thread is in."""

    blocks = 0


class _WithoutQuietThreads:
    """A stream that drops what threads inside a quiet block write and passes on the rest."""

    def __init__(self, stream: TextIO | None):
        self.replaces = stream
        self._stream = _beside(stream) or io.StringIO()  # None in a program without a terminal

    def __del__(self) -> None:
        """Close the copy when another stream has replaced the one that it was made for."""
        stream = self.__dict__.get("_stream")
        if stream is not None and stream is not self.replaces:
            stream.close()

    def write(self, text: str) -> int:
        """Write text; called by `print`."""
        return len(text) if _depth.blocks else self._stream.write(text)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)


def _beside(stream: TextIO | None) -> TextIO | None:
    """Return a stream to the target of `stream`, for the time the process's descriptor is muted."""
    if stream is None or not _is_process_stream(stream, 1):
        return stream
    return open(os.dup(1), "w", 1, stream.encoding, stream.errors)


_depth = _Depth()
# The last one stays: `print` in another thread may be using it without a reference of its own.
_last_quiet: list[_WithoutQuietThreads] = []
_lock = threading.Lock()
_undo = ExitStack()
_threads_inside = 0


@contextlib.contextmanager
def quiet_library() -> Iterator[None]:
    """Drop what this thread prints to stdout inside the block, and what C writes anywhere.

    The library warns of damaged pixels on Python's stdout, where results belong, and its C core
    writes to the process's stdout and stderr. Several threads may be inside at once, and what
    others print gets through; what C code writes is lost for all of them: keep the block short.
    """
    _enter()
    _depth.blocks += 1
    try:
        yield
    finally:
        _depth.blocks -= 1
        _leave()


def _enter() -> None:
    """Mute for the first thread: each thread alone would restore what another had put there."""
    global _threads_inside
    with _lock:
        if _threads_inside == 0:
            _undo.enter_context(_muted_process())
        _threads_inside += 1


def _leave() -> None:
    """Restore everything after the last thread."""
    global _threads_inside
    with _lock:
        _threads_inside -= 1
        if _threads_inside == 0:
            _undo.close()


@contextlib.contextmanager
def _muted_process() -> Iterator[None]:
    """Mute both streams for the block."""
    stdout: Any = _quiet_stdout()
    with contextlib.suppress(OSError, ValueError):  # whoever prints next will be told of it
        if sys.stdout is not None:
            sys.stdout.flush()
    with contextlib.redirect_stdout(stdout), _muted_descriptor(1), _muted_stderr():
        yield


@contextlib.contextmanager
def _muted_descriptor(number: int) -> Iterator[int | None]:
    """Point a descriptor of the process nowhere for the block; gives another one to where it was.

    None in a program without it, as under pythonw: there is nothing to mute.
    """
    try:
        saved = os.dup(number)
    except OSError:
        yield None
        return
    nowhere = os.open(os.devnull, os.O_WRONLY)
    try:
        os.dup2(nowhere, number)
        yield saved
    finally:
        _flush_c()
        os.dup2(saved, number)
        os.close(saved)
        os.close(nowhere)


def _flush_c() -> None:
    """Have C write what it keeps of its own stdout: it would come out when the program ends."""
    if os.name == "posix":
        ctypes.CDLL(None).fflush(None)


def _quiet_stdout() -> _WithoutQuietThreads:
    """Return one stream for as long as stdout is the same, so that it is never freed while in use.

    Before Python 3.14, `print` only borrows what it finds in sys.stdout.
    """
    if not _last_quiet or _last_quiet[0].replaces is not sys.stdout:
        _last_quiet[:] = [_WithoutQuietThreads(sys.stdout)]
    return _last_quiet[0]


@contextlib.contextmanager
def _muted_stderr() -> Iterator[None]:
    """Point the process's stderr nowhere for the block, but let Python's own go on as before."""
    goes_through = _is_process_stream(sys.stderr, 2)
    with _muted_descriptor(2) as saved:
        if saved is None or not goes_through:
            yield
            return
        with _python_stderr_to(saved):
            yield


@contextlib.contextmanager
def _python_stderr_to(descriptor: int) -> Iterator[None]:
    """Let Python, which writes its stderr to the process's, write to `descriptor` instead."""
    encoding = sys.stderr.encoding
    with (
        open(descriptor, "w", 1, encoding, "backslashreplace", closefd=False) as stream,
        contextlib.redirect_stderr(stream),
    ):
        yield


def _is_process_stream(stream: TextIO | None, number: int) -> bool:
    """Return True for a stream on that descriptor.

    A test or a window may have put another there.
    """
    try:
        return stream is not None and stream.fileno() == number
    except (OSError, ValueError):
        return False

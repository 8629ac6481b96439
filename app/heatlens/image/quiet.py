"""Keep the OpenEXR library's own words off the terminal: each failure has one sentence, ours."""

import contextlib
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
        self._stream = stream or io.StringIO()  # None in a program without a terminal

    def write(self, text: str) -> int:
        """Called by `print`."""
        return len(text) if _depth.blocks else self._stream.write(text)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)


_depth = _Depth()
# The last one stays: `print` in another thread may be using it without a reference of its own.
_last_quiet: list[_WithoutQuietThreads] = []
_lock = threading.Lock()
_undo = ExitStack()
_threads_inside = 0


@contextlib.contextmanager
def quiet_library() -> Iterator[None]:
    """Drop what this thread prints to stdout inside the block, and what C writes to stderr.

    The library warns of damaged pixels on Python's stdout, where results belong, and its C core
    writes to the process's stderr. Several threads may be inside at once, and what others print
    gets through; what C code writes to stderr is lost for all of them, so keep the block short.
    """
    _enter()
    _depth.blocks += 1
    try:
        yield
    finally:
        _depth.blocks -= 1
        _leave()


def _enter() -> None:
    """The first thread in mutes: each on its own would restore what another had put there."""
    global _threads_inside
    with _lock:
        if _threads_inside == 0:
            _undo.enter_context(_muted_process())
        _threads_inside += 1


def _leave() -> None:
    """The last thread out puts everything back."""
    global _threads_inside
    with _lock:
        _threads_inside -= 1
        if _threads_inside == 0:
            _undo.close()


@contextlib.contextmanager
def _muted_process() -> Iterator[None]:
    """Both streams quiet for the block."""
    stdout: Any = _quiet_stdout()
    with contextlib.redirect_stdout(stdout), _muted_stderr():
        yield


def _quiet_stdout() -> _WithoutQuietThreads:
    """One stream for as long as stdout is the same, so that it never goes while it is written to.

    Before Python 3.14, `print` only borrows what it finds in sys.stdout.
    """
    if not _last_quiet or _last_quiet[0].replaces is not sys.stdout:
        _last_quiet[:] = [_WithoutQuietThreads(sys.stdout)]
    return _last_quiet[0]


@contextlib.contextmanager
def _muted_stderr() -> Iterator[None]:
    """Point the process's stderr nowhere for the block, but let Python's own go on as before."""
    try:
        saved = os.dup(2)
    except OSError:  # a program without a stderr, as under pythonw: nothing to mute
        yield
        return
    nowhere = os.open(os.devnull, os.O_WRONLY)
    try:
        with _python_stderr_to(saved):
            os.dup2(nowhere, 2)
            yield
    finally:
        os.dup2(saved, 2)
        os.close(saved)
        os.close(nowhere)


@contextlib.contextmanager
def _python_stderr_to(descriptor: int) -> Iterator[None]:
    """Where Python writes its stderr to the process's, let it write to `descriptor` instead."""
    if not _is_process_stderr(sys.stderr):
        yield
        return
    encoding = sys.stderr.encoding
    with (
        open(descriptor, "w", 1, encoding, "backslashreplace", closefd=False) as stream,
        contextlib.redirect_stderr(stream),
    ):
        yield


def _is_process_stderr(stream: TextIO | None) -> bool:
    """True for a stream on descriptor 2; a test or a window may have put another there."""
    try:
        return stream is not None and stream.fileno() == 2
    except (OSError, ValueError):
        return False

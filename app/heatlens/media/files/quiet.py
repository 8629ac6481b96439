"""Keep messages of the OpenEXR library off the terminal, because heatlens reports errors itself.

The library can only be muted by pointing the process's descriptors 1 and 2 to nowhere for a while,
on any thread. A line that another thread prints at that moment would be lost or cut, so a program
that prints from one thread and reads files on others calls `protect_output` when it starts.
"""

import contextlib
import ctypes
import io
import os
import sys
import threading
from collections.abc import Iterator
from contextlib import ExitStack
from typing import Any, TextIO

from heatlens.core.base.log import FILE_VARIABLE


class _Depth(threading.local):
    """The number of quiet blocks that the current thread is in."""

    blocks = 0


class _MutableStdout:
    """A stdout that drops output of threads in a quiet block, and passes on all other output."""

    def __init__(self, stream: TextIO | None):
        self.original = stream
        self._stream = _copy_of(stream) or io.StringIO()  # None in a program without a terminal

    def __del__(self) -> None:
        """Close the copy of the original stream, if one was made."""
        stream = self.__dict__.get("_stream")
        if stream is not None and stream is not self.original:
            stream.close()

    def write(self, text: str) -> int:
        """Write text, or drop it in a quiet block; `print` calls this."""
        return len(text) if _depth.blocks else self._stream.write(text)

    def __getattr__(self, name: str) -> object:
        return getattr(self._stream, name)


def _copy_of(stream: TextIO | None) -> TextIO | None:
    """Return a stream to the same target that works while the process's descriptor is muted."""
    if stream is None or not _is_process_stream(stream, 1):
        return stream
    return open(os.dup(1), "w", 1, stream.encoding, stream.errors)


_depth = _Depth()
# Keeps the last stream alive: `print` in another thread may use it without a reference.
_last_streams: list[_MutableStdout] = []
_lock = threading.Lock()
_restore_stack = ExitStack()
_threads_inside = 0
_is_protected = False


def protect_output() -> None:
    """Give Python's stdout and stderr descriptors of their own, which are never muted.

    What drivers and libraries print on the process's stdout then goes to stderr: programs read the
    results of a command on stdout, a picture among them.
    """
    global _is_protected
    _is_protected = True
    for name, number in (("stdout", 1), ("stderr", 2)):
        stream = getattr(sys, name)
        if _is_process_stream(stream, number):
            setattr(sys, name, _duplicate(stream, number))
    with contextlib.suppress(OSError):  # started without a stderr
        os.dup2(2, 1)


def mute_libraries() -> None:
    """Keep what libraries print on stderr from now on in the log, if there is one, else drop it.

    This is for a library that prints pages before it ends the process, whose end is told in a
    sentence. Without `protect_output` before, nothing changes.
    """
    if _is_protected:
        with contextlib.suppress(OSError):
            target = os.environ.get(FILE_VARIABLE) or os.devnull
            descriptor = os.open(target, os.O_WRONLY | os.O_APPEND | os.O_CREAT, 0o666)
            os.dup2(descriptor, 2)
            os.close(descriptor)


def _duplicate(stream: TextIO, number: int) -> TextIO:
    """Return a stream with a copy of the descriptor `number`, buffered as `stream` is."""
    stream.flush()
    buffering = 1 if stream.line_buffering else -1
    return open(os.dup(number), "w", buffering, stream.encoding, stream.errors)


@contextlib.contextmanager
def quiet_library() -> Iterator[None]:
    """Drop what this thread prints to stdout inside the block, and all output of C code.

    The library prints warnings about damaged pixels to Python's stdout, where results belong, and
    its C core writes to the process's stdout and stderr. Several threads may be inside at once, and
    prints of other threads get through. The output of C code is lost for all threads, so keep the
    block short.
    """
    _mute_for_first()
    _depth.blocks += 1
    try:
        yield
    finally:
        _depth.blocks -= 1
        _restore_after_last()


def _mute_for_first() -> None:
    """Mute the process when the first thread enters.

    If each thread did so, one could restore the muted streams of another.
    """
    global _threads_inside
    with _lock:
        if _threads_inside == 0:
            _restore_stack.enter_context(_mute_process())
        _threads_inside += 1


def _restore_after_last() -> None:
    """Restore the streams when the last thread leaves."""
    global _threads_inside
    with _lock:
        _threads_inside -= 1
        if _threads_inside == 0:
            _restore_stack.close()


@contextlib.contextmanager
def _mute_process() -> Iterator[None]:
    """Mute stdout and stderr of the process for the block."""
    stdout: Any = _shared_stdout()
    with contextlib.suppress(OSError, ValueError):  # the next print reports such an error
        if sys.stdout is not None:
            sys.stdout.flush()
    with contextlib.redirect_stdout(stdout), _mute_descriptor(1), _mute_stderr():
        yield


@contextlib.contextmanager
def _mute_descriptor(number: int) -> Iterator[int | None]:
    """Point a descriptor of the process to nowhere for the block; yield a copy of the old one.

    Yields None if the process does not have the descriptor, as under pythonw.
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
    """Flush C's own buffer of stdout, which would otherwise be printed when the program ends."""
    if sys.platform != "win32":
        ctypes.CDLL(None).fflush(None)


def _shared_stdout() -> _MutableStdout:
    """Return one stream for all quiet blocks, as long as stdout stays the same.

    It is never freed while in use: before Python 3.14, `print` holds no reference to sys.stdout.
    """
    if not _last_streams or _last_streams[0].original is not sys.stdout:
        _last_streams[:] = [_MutableStdout(sys.stdout)]
    return _last_streams[0]


@contextlib.contextmanager
def _mute_stderr() -> Iterator[None]:
    """Point the process's stderr to nowhere for the block, but keep Python's own working."""
    is_process_stderr = _is_process_stream(sys.stderr, 2)
    with _mute_descriptor(2) as saved:
        if saved is None or not is_process_stderr:
            yield
            return
        with _redirect_python_stderr(saved):
            yield


@contextlib.contextmanager
def _redirect_python_stderr(descriptor: int) -> Iterator[None]:
    """Redirect Python's stderr to `descriptor` for the block."""
    encoding = sys.stderr.encoding
    with (
        open(descriptor, "w", 1, encoding, "backslashreplace", closefd=False) as stream,
        contextlib.redirect_stderr(stream),
    ):
        yield


def _is_process_stream(stream: TextIO | None, number: int) -> bool:
    """Return True if `stream` writes to the descriptor `number`.

    Tests and windows may replace the standard streams.
    """
    try:
        return stream is not None and stream.fileno() == number
    except (OSError, ValueError):
        return False

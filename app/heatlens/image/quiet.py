"""Keep the OpenEXR library's own words off the terminal: each failure has one sentence, ours."""

import contextlib
import io
import os
from collections.abc import Iterator


@contextlib.contextmanager
def quiet_library() -> Iterator[None]:
    """Drop what is printed inside the block, by Python to stdout and by C to stderr.

    The library warns of damaged pixels on Python's stdout, where results belong, and its C core
    writes to the process's stderr. Both are shared by the whole process, so keep the block short.
    """
    with contextlib.redirect_stdout(io.StringIO()), _muted_stderr():
        yield


@contextlib.contextmanager
def _muted_stderr() -> Iterator[None]:
    """Point the process's stderr nowhere for the block."""
    try:
        saved = os.dup(2)
    except OSError:  # a program without a stderr, as under pythonw: nothing to mute
        yield
        return
    nowhere = os.open(os.devnull, os.O_WRONLY)
    try:
        os.dup2(nowhere, 2)
        yield
    finally:
        os.dup2(saved, 2)
        os.close(saved)
        os.close(nowhere)

"""Lock a file that several processes of this user read, change and write."""

import os
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

try:
    import fcntl
except ImportError:  # no such module on Windows; two windows at once may then lose a change
    fcntl = None  # type: ignore[assignment]

_PATIENCE_S = 2.0  # a process that stopped in the middle must not block the others forever


@contextmanager
def locked(path: Path) -> Iterator[None]:
    """Wait, but not for long, until no other process is in such a block for the same `path`.

    The file system of a server may have no locks; the block is then entered at once. Raises OSError
    if the file `path`, which stays empty, cannot be made.
    """
    flags = os.O_RDWR | os.O_CREAT | getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_NONBLOCK", 0)
    opened = os.open(path, flags, 0o600)
    try:
        end = time.monotonic() + _PATIENCE_S
        while not _is_taken(opened) and time.monotonic() < end:
            time.sleep(0.02)
        yield
    finally:
        os.close(opened)  # this releases the lock


def _is_taken(opened: int) -> bool:
    """Return False while another process has the lock."""
    try:
        if fcntl is not None:
            fcntl.flock(opened, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    except OSError:  # a file system without locks
        return True
    return True

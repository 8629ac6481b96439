"""Lock a file that several processes of this user read, change and write."""

import os
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

_LOCK_WAIT_S = 2.0  # a process that stopped in the middle must not block the others forever


@contextmanager
def lock_file(path: Path) -> Iterator[None]:
    """Lock `path` for the block, and wait up to `_LOCK_WAIT_S` while another process has the lock.

    The file system of a server may have no locks; the block is then entered at once. Raises OSError
    if the file `path`, which stays empty, cannot be made.
    """
    flags = os.O_RDWR | os.O_CREAT | getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_NONBLOCK", 0)
    descriptor = os.open(path, flags, 0o600)
    try:
        deadline = time.monotonic() + _LOCK_WAIT_S
        while not _try_lock(descriptor) and time.monotonic() < deadline:
            time.sleep(0.02)
        yield
    finally:
        os.close(descriptor)  # this releases the lock


def _try_lock(descriptor: int) -> bool:
    """Lock an open file without waiting; return False while another process has the lock."""
    if sys.platform == "win32":
        import msvcrt

        try:
            msvcrt.locking(descriptor, msvcrt.LK_NBLCK, 1)  # a byte, which need not be there
        except OSError:  # the same error for a lock of another and for no locks at all
            return False
        return True
    import fcntl

    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    except OSError:  # a file system without locks
        return True
    return True

"""Ask the system how much memory is free, and let threads share what is freed."""

import ctypes
import sys
from pathlib import Path

_MEMINFO = Path("/proc/meminfo")
_ARENA_MAX = -8  # M_ARENA_MAX of glibc's malloc.h


def free_memory_bytes() -> int | None:
    """Return the bytes that Linux could give without swapping; None if they are unknown."""
    try:
        fields = dict(line.split(":", 1) for line in _MEMINFO.read_text("ascii").splitlines())
        return int(fields["MemAvailable"].split()[0]) * 1024
    except (OSError, KeyError, ValueError):  # not Linux, or an old version of it
        return None


def share_one_heap() -> None:
    """Let all threads of this process allocate from one heap, before the first thread starts.

    By default glibc gives threads heaps of their own, up to eight for each core. Such a heap keeps
    its largest size, about 26 MB for a thread that read a plate, when all in it has been freed.
    """
    mallopt = getattr(ctypes.CDLL(None), "mallopt", None) if sys.platform == "linux" else None
    if mallopt is not None:
        mallopt(_ARENA_MAX, 1)

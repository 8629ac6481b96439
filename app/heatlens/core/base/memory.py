"""Ask the system about memory, of the machine and of processes; and let threads share what is free.

All numbers are bytes. What a system does not say is None.
"""

import ctypes
import subprocess
import sys
from pathlib import Path

_MEMINFO = Path("/proc/meminfo")
_PAGES = Path("/proc/self/statm")
_PEAK_UNIT_BYTES = 1 if sys.platform == "darwin" else 1024  # the unit of ru_maxrss
_ARENA_MAX = -8  # M_ARENA_MAX of glibc's malloc.h


def free_memory_bytes() -> int | None:
    """Return what the system could give without swapping; None on macOS."""
    if sys.platform == "win32":
        from heatlens.core.base.windows_calls import memory_of_machine

        return memory_of_machine().free_bytes
    try:
        fields = dict(line.split(":", 1) for line in _MEMINFO.read_text("ascii").splitlines())
        return int(fields["MemAvailable"].split()[0]) * 1024
    except (OSError, KeyError, ValueError):  # not Linux, or an old version of it
        return None


def total_memory_bytes() -> int | None:
    """Return the memory of the machine; None if that is unknown."""
    if sys.platform == "win32":
        from heatlens.core.base.windows_calls import memory_of_machine

        return memory_of_machine().total_bytes
    import os

    try:
        return os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    except (ValueError, OSError):
        return None


def resident_bytes() -> int | None:
    """Return the memory that this process holds now; None on macOS."""
    if sys.platform == "win32":
        from heatlens.core.base.windows_calls import memory_of_this_process

        return memory_of_this_process().resident_bytes
    import resource

    try:
        return int(_PAGES.read_text("ascii").split()[1]) * resource.getpagesize()
    except OSError:
        return None


def peak_bytes() -> int:
    """Return the most memory that this process held, with textures that a processor draws in."""
    if sys.platform == "win32":
        from heatlens.core.base.windows_calls import memory_of_this_process

        return memory_of_this_process().peak_bytes
    import resource

    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * _PEAK_UNIT_BYTES


def wait_for_peak_bytes(process: "subprocess.Popen[bytes]") -> int:
    """Wait until a child process ends; return the most memory that it held."""
    if sys.platform == "win32":
        from heatlens.core.base.windows_calls import memory_of_child

        process.wait()
        return memory_of_child(process.pid).peak_bytes
    import os

    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    return usage.ru_maxrss * _PEAK_UNIT_BYTES


def share_one_heap() -> None:
    """Let all threads of this process allocate from one heap, before the first thread starts.

    By default glibc gives threads heaps of their own, up to eight for each core. Such a heap keeps
    its largest size, about 26 MB for a thread that read a plate, when all in it has been freed.
    """
    mallopt = getattr(ctypes.CDLL(None), "mallopt", None) if sys.platform == "linux" else None
    if mallopt is not None:
        mallopt(_ARENA_MAX, 1)


def give_back_freed_memory() -> None:
    """Give the memory that this process has freed back to the system, where glibc keeps it.

    After a plate was read, glibc keeps about as much as the plate needs. This takes milliseconds.
    """
    trim = getattr(ctypes.CDLL(None), "malloc_trim", None) if sys.platform == "linux" else None
    if trim is not None:
        trim(0)

"""Call Windows itself: the only file that does, and is imported there alone.

The structures and numbers are those of Windows' own headers, `winnt.h`, `psapi.h` and
`sysinfoapi.h`; their names there stand in the comments.
"""

import ctypes
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import ClassVar, NamedTuple

assert sys.platform == "win32"  # so that type checkers for other systems skip the rest

_KERNEL = ctypes.WinDLL("kernel32", use_last_error=True)
_KERNEL.GetCurrentProcess.restype = ctypes.c_void_p
_KERNEL.OpenProcess.restype = ctypes.c_void_p
_QUERY_LIMITED_INFORMATION = 0x1000  # PROCESS_QUERY_LIMITED_INFORMATION


class _MemoryStatus(ctypes.Structure):
    """MEMORYSTATUSEX."""

    _fields_: ClassVar = [
        ("length", ctypes.c_uint32),
        ("load", ctypes.c_uint32),
        ("total_bytes", ctypes.c_uint64),
        ("free_bytes", ctypes.c_uint64),
        ("others", ctypes.c_uint64 * 5),  # of the page file and of addresses
    ]


class _ProcessMemory(ctypes.Structure):
    """PROCESS_MEMORY_COUNTERS."""

    _fields_: ClassVar = [
        ("length", ctypes.c_uint32),
        ("page_faults", ctypes.c_uint32),
        ("peak_bytes", ctypes.c_size_t),  # PeakWorkingSetSize
        ("resident_bytes", ctypes.c_size_t),  # WorkingSetSize
        ("others", ctypes.c_size_t * 6),  # of pools and the page file
    ]


class MachineMemory(NamedTuple):
    """The memory of the machine."""

    total_bytes: int
    free_bytes: int


class ProcessMemory(NamedTuple):
    """The memory that a process holds, and the most that it held."""

    resident_bytes: int
    peak_bytes: int


def memory_of_machine() -> MachineMemory:
    """Return the memory of the machine. Raises OSError."""
    status = _MemoryStatus(length=ctypes.sizeof(_MemoryStatus))
    _check(_KERNEL.GlobalMemoryStatusEx(ctypes.byref(status)))
    return MachineMemory(status.total_bytes, status.free_bytes)


def memory_of_this_process() -> ProcessMemory:
    """Return the memory of this process. Raises OSError."""
    return _memory_of_process(_KERNEL.GetCurrentProcess())


def memory_of_child(number: int) -> ProcessMemory:
    """Return the memory of a process of this one, which may have ended. Raises OSError.

    Windows remembers its `number` and memory as long as Python's object for the process exists.
    """
    with _open_process(number, _QUERY_LIMITED_INFORMATION) as handle:
        return _memory_of_process(handle)


@contextmanager
def _open_process(number: int, rights: int) -> Iterator[int]:
    """Yield a handle to the process with this number. Raises OSError."""
    handle = _KERNEL.OpenProcess(rights, False, number)
    _check(handle)
    try:
        yield handle
    finally:
        _KERNEL.CloseHandle(ctypes.c_void_p(handle))


def _memory_of_process(handle: int) -> ProcessMemory:
    counters = _ProcessMemory(length=ctypes.sizeof(_ProcessMemory))
    _check(
        _KERNEL.K32GetProcessMemoryInfo(
            ctypes.c_void_p(handle), ctypes.byref(counters), counters.length
        )
    )
    return ProcessMemory(counters.resident_bytes, counters.peak_bytes)


def _check(succeeded: int | None) -> None:
    """Raise the OSError of the last call unless it succeeded."""
    if not succeeded:
        raise ctypes.WinError(ctypes.get_last_error())

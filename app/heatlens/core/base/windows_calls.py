"""Call Windows itself: the only file that does, and is imported there alone.

The structures and numbers are those of Windows' own headers, `winnt.h`, `psapi.h` and
`sysinfoapi.h`; their names there stand in the comments.
"""

import ctypes
import msvcrt
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import ClassVar, NamedTuple

assert sys.platform == "win32"  # so that type checkers for other systems skip the rest

_KERNEL = ctypes.WinDLL("kernel32", use_last_error=True)
_KERNEL.GetCurrentProcess.restype = ctypes.c_void_p
_KERNEL.OpenProcess.restype = ctypes.c_void_p
_KERNEL.CreateJobObjectW.restype = ctypes.c_void_p
_QUERY_LIMITED_INFORMATION = 0x1000  # PROCESS_QUERY_LIMITED_INFORMATION
_SYNCHRONIZE = 0x0010_0000
_FOREVER_MS, _TIMEOUT = 0xFFFF_FFFF, 258  # INFINITE, WAIT_TIMEOUT
_EXTENDED_LIMITS = 9  # JobObjectExtendedLimitInformation
_LIMITS_TIME, _LIMITS_MEMORY = 0x2, 0x100  # JOB_OBJECT_LIMIT_PROCESS_TIME, ..._MEMORY
_TICKS_A_SECOND = 10_000_000
_SEQUENCES = 0x4  # ENABLE_VIRTUAL_TERMINAL_PROCESSING
TIME_EXIT_CODE = 1816  # ERROR_NOT_ENOUGH_QUOTA, of a process that took all its time


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


class _JobLimits(ctypes.Structure):
    """JOBOBJECT_EXTENDED_LIMIT_INFORMATION."""

    _fields_: ClassVar = [
        ("process_ticks", ctypes.c_int64),  # PerProcessUserTimeLimit
        ("job_ticks", ctypes.c_int64),
        ("flags", ctypes.c_uint32),
        ("working_sets", ctypes.c_size_t * 2),
        ("most_processes", ctypes.c_uint32),
        ("affinity", ctypes.c_size_t),
        ("classes", ctypes.c_uint32 * 2),
        ("io_counters", ctypes.c_uint64 * 6),
        ("process_bytes", ctypes.c_size_t),  # ProcessMemoryLimit
        ("others", ctypes.c_size_t * 3),  # of the job, and peaks
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


def is_running(number: int) -> bool:
    """Return whether there is a process with this number that has not ended."""
    try:
        with _open_process(number, _SYNCHRONIZE) as handle:
            return _wait(handle, 0) == _TIMEOUT
    except PermissionError:  # alive, and owned by another user
        return True
    except OSError:
        return False


def wait_for_process(number: int) -> None:
    """Wait until the process with this number has ended."""
    with suppress(OSError), _open_process(number, _SYNCHRONIZE) as handle:
        _wait(handle, _FOREVER_MS)


def _wait(handle: int, timeout_ms: int) -> int:
    return int(_KERNEL.WaitForSingleObject(ctypes.c_void_p(handle), ctypes.c_uint32(timeout_ms)))


class ProcessLimits:
    """Limits of processor time and memory of this process, which Windows enforces."""

    def __init__(self) -> None:
        """Put this process into a job object. Raises OSError."""
        self._job = ctypes.c_void_p(_KERNEL.CreateJobObjectW(None, None))
        process = ctypes.c_void_p(_KERNEL.GetCurrentProcess())
        _check(_KERNEL.AssignProcessToJobObject(self._job, process))

    def set(self, seconds: float, memory_bytes: int) -> None:
        """Set both limits. Raises OSError."""
        limits = _JobLimits(
            process_ticks=round(seconds * _TICKS_A_SECOND),
            flags=_LIMITS_TIME | _LIMITS_MEMORY,
            process_bytes=memory_bytes,
        )
        size = ctypes.sizeof(limits)
        _check(
            _KERNEL.SetInformationJobObject(self._job, _EXTENDED_LIMITS, ctypes.byref(limits), size)
        )


def take_sequences(descriptor: int) -> bool:
    """Ask the console of a descriptor to obey ESC sequences; return whether it does."""
    handle, mode = ctypes.c_void_p(msvcrt.get_osfhandle(descriptor)), ctypes.c_uint32()
    return bool(
        _KERNEL.GetConsoleMode(handle, ctypes.byref(mode))
        and _KERNEL.SetConsoleMode(handle, mode.value | _SEQUENCES)
    )


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
    """Return the memory of the process with this handle. Raises OSError."""
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

"""What heatlens asks of Windows itself, answered by Linux: memory, processes, limits and locks."""

import ctypes
import fcntl
import os
import resource
import types
from collections.abc import Callable
from typing import Any

MEMORY_BYTES, FREE_BYTES = 64 << 30, 16 << 30
_QUERY = 0x1000  # PROCESS_QUERY_LIMITED_INFORMATION


class Kernel:
    """The functions of kernel32 that `windows_calls` calls; ones for success, as there.

    The handle of a process is its number.
    """

    def __init__(self, name: str, use_last_error: bool) -> None:
        assert name == "kernel32" and use_last_error
        self.GetCurrentProcess = Function(os.getpid)
        self.OpenProcess = Function(_open_process)
        self.CloseHandle = Function(lambda _handle: 1)
        self.GlobalMemoryStatusEx = Function(_fill_memory_status)
        self.K32GetProcessMemoryInfo = Function(_fill_process_memory)


def _open_process(rights: int, is_inherited: bool, number: int) -> int | None:
    """Windows remembers ended children of this process, and Linux does not."""
    assert rights and not is_inherited
    return number if rights == _QUERY or os.path.exists(f"/proc/{number}") else None


def _fill_memory_status(status: Any) -> int:
    assert status._obj.length == ctypes.sizeof(status._obj) == 64
    status._obj.total_bytes, status._obj.free_bytes = MEMORY_BYTES, FREE_BYTES
    return 1


def _fill_process_memory(_handle: object, counters: Any, length: int) -> int:
    assert length == ctypes.sizeof(counters._obj) == 72
    peak_bytes = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024
    counters._obj.resident_bytes = counters._obj.peak_bytes = peak_bytes
    return 1


class Function:
    """A function of a library, which has the type of its result as an attribute."""

    def __init__(self, function: Callable[..., int | None]) -> None:
        self.restype: type | None = None
        self._function = function

    def __call__(self, *values: object) -> int | None:
        return self._function(*values)


class Locks(types.ModuleType):
    """The module msvcrt, with locks on the first byte of an open file."""

    LK_NBLCK = 2

    def __init__(self) -> None:
        super().__init__("msvcrt")

    def locking(self, descriptor: int, mode: int, count: int) -> None:
        assert mode == self.LK_NBLCK and count == 1
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise PermissionError(13, "Permission denied") from None

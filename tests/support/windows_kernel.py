"""What heatlens asks of Windows itself, answered by Linux: memory, processes, limits and locks."""

import ctypes
import fcntl
import os
import resource
import time
import types
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
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
        self.WaitForSingleObject = Function(_wait)
        self.limits: list[tuple[int, int, int]] = []  # flags, ticks and bytes, as they were set
        self.CreateJobObjectW = Function(lambda _security, _name: 7)
        self.AssignProcessToJobObject = Function(
            lambda job, process: int(job.value == 7 and process.value == os.getpid())
        )
        self.SetInformationJobObject = Function(self._set_limits)
        self.is_console_new = True
        self.GetConsoleMode = Function(lambda _handle, _mode: 1)
        self.SetConsoleMode = Function(lambda _handle, mode: int(self.is_console_new and mode & 4))

    def _set_limits(self, _job: object, kind: int, limits: Any, size: int) -> int:
        assert kind == 9 and size == ctypes.sizeof(limits._obj) == 144
        values = limits._obj
        self.limits.append((values.flags, values.process_ticks, values.process_bytes))
        return 1


def _wait(process: Any, timeout_ms: Any) -> int:
    """Wait for a process; return 0 for an ended one, and 258 after the time."""
    with suppress(OSError, IndexError):
        while Path(f"/proc/{process.value}/stat").read_text().rpartition(")")[2].split()[0] != "Z":
            if timeout_ms.value == 0:
                return 258
            time.sleep(0.02)
    return 0


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

    def get_osfhandle(self, descriptor: int) -> int:
        return descriptor

    def locking(self, descriptor: int, mode: int, count: int) -> None:
        assert mode == self.LK_NBLCK and count == 1
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise PermissionError(13, "Permission denied") from None

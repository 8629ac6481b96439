"""Test what heatlens does on Windows otherwise, against a stand-in of its kernel.

`support/windows_kernel.py` answers; the sizes of the structures are those of Windows' headers.
"""

import ctypes
import importlib
import io
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType, SimpleNamespace

import pytest

from heatlens.core.base import memory
from heatlens.core.base.errors import InputError
from heatlens.deliver.farm import processes
from heatlens.fronts.commands.output import progress_line
from heatlens.media.files import atomic_file, file_lock, limits
from support.patience import PATIENCE_S
from support.windows_kernel import FREE_BYTES, MEMORY_BYTES, Kernel, Locks

CTRL_BREAK = 99
CALLS = "heatlens.core.base.windows_calls"


@pytest.fixture
def calls(monkeypatch) -> Iterator[ModuleType]:
    """Import the calls of Windows, and let the modules under test believe to be there."""
    with monkeypatch.context() as patch:
        patch.setattr(sys, "platform", "win32")
        patch.setattr(ctypes, "WinDLL", Kernel, raising=False)
        patch.setitem(sys.modules, "msvcrt", Locks())
        imported = importlib.import_module(CALLS)
    monkeypatch.setitem(sys.modules, "msvcrt", Locks())
    monkeypatch.setattr(ctypes, "WinError", OSError, raising=False)
    monkeypatch.setattr(ctypes, "get_last_error", lambda: 0, raising=False)
    for module in (memory, processes, progress_line, atomic_file, file_lock, limits):
        there = SimpleNamespace(platform="win32", stderr=sys.stderr)
        monkeypatch.setattr(module, "sys", there)
    yield imported
    del sys.modules[CALLS]


def ended_process() -> int:
    with subprocess.Popen([sys.executable, "-c", ""]) as process:
        process.wait()
    return process.pid


def test_memory_is_that_of_the_system(calls):
    assert memory.total_memory_bytes() == MEMORY_BYTES
    assert memory.free_memory_bytes() == FREE_BYTES
    assert memory.resident_bytes() == memory.peak_bytes() > 10_000_000


def test_unfinished_file_is_removed_once_its_writer_has_ended(calls, tmp_path):
    living, dead = (
        tmp_path / f".heatlens-{'0' * 16}.{atomic_file._MACHINE}.{number}.part"
        for number in (os.getpid(), ended_process())
    )
    for path in (living, dead):
        path.write_bytes(b"half")
    atomic_file.remove_leftovers(tmp_path)
    assert living.exists() and not dead.exists()


def test_child_waits_for_the_end_of_its_parent(calls):
    process = subprocess.Popen([sys.executable, "-c", "input()"], stdin=subprocess.PIPE)
    assert calls.is_running(process.pid)
    process.communicate(b"\n")
    calls.wait_for_process(process.pid)
    assert not calls.is_running(process.pid)


def test_two_windows_do_not_hold_one_lock(calls, tmp_path):
    first, second = (os.open(tmp_path / "lock", os.O_RDWR | os.O_CREAT) for _ in range(2))
    assert file_lock._try_lock(first) and not file_lock._try_lock(second)
    os.close(first)
    assert file_lock._try_lock(second)
    os.close(second)


class Viewer:
    """A program that has the target open for some time: nobody can rename over it."""

    def __init__(self, monkeypatch, seconds: float) -> None:
        self.end_s = time.monotonic() + seconds
        self._replace = os.replace
        monkeypatch.setattr(os, "replace", self.replace)

    def replace(self, source: Path, target: Path) -> None:
        if time.monotonic() < self.end_s:
            raise PermissionError(13, "Access is denied")
        self._replace(source, target)


def test_file_that_a_viewer_has_open_is_replaced_when_it_lets_go(calls, tmp_path, monkeypatch):
    path = tmp_path / "picture.exr"
    path.write_bytes(b"old")
    Viewer(monkeypatch, seconds=0.2)
    atomic_file.write_atomically(path, b"new")
    assert path.read_bytes() == b"new"


def test_file_that_stays_open_is_told_and_left(calls, tmp_path, monkeypatch):
    path = tmp_path / "picture.exr"
    path.write_bytes(b"old")
    monkeypatch.setattr(atomic_file, "_OPEN_WAIT_S", 0.1)
    Viewer(monkeypatch, seconds=60.0)
    with pytest.raises(InputError, match=r"another program has it open\. Close it there"):
        atomic_file.write_atomically(path, b"new")
    assert path.read_bytes() == b"old" and os.listdir(tmp_path) == ["picture.exr"]


def test_reading_process_sets_and_extends_its_limits(calls, tmp_path, monkeypatch):
    monkeypatch.setattr(limits, "ProcessLimits", calls.ProcessLimits, raising=False)
    monkeypatch.setattr(limits, "TIME_EXIT_CODE", calls.TIME_EXIT_CODE, raising=False)
    monkeypatch.setattr(limits, "_process_limits", [], raising=False)
    monkeypatch.setattr(limits, "_allowed", {})
    watched_s: list[float] = []
    monkeypatch.setattr(limits, "_watch_elapsed", watched_s.append)
    limits.bound_this_process()
    scene = tmp_path / "scene.usd"
    scene.write_bytes(bytes(2_000_000))
    limits.allow_for(scene)
    time_and_memory, a_second = 0x102, 10_000_000
    assert calls._KERNEL.limits == [
        (time_and_memory, seconds * a_second, 3_000_000_000) for seconds in (10, 30)
    ]
    assert watched_s == [300.0, 900.0]
    assert limits.is_time_exit(1816) and not limits.is_time_exit(1)


class DeafProcess(subprocess.Popen):
    """Waits for input, and does not obey when it is asked to stop."""

    def __init__(self) -> None:
        super().__init__([sys.executable, "-c", "input()"], stdin=subprocess.PIPE)
        self.was_asked = False

    def send_signal(self, number: int) -> None:
        if number == CTRL_BREAK:
            self.was_asked = True
        else:
            super().send_signal(number)


def test_child_is_asked_to_stop_and_then_killed(calls, monkeypatch):
    """SIGTERM would end a process on Windows at once, with its files half written."""
    monkeypatch.setattr(processes.signal, "CTRL_BREAK_EVENT", CTRL_BREAK, raising=False)
    monkeypatch.setattr(processes, "PATIENCE_S", 0.1)
    with DeafProcess() as process:
        processes.stop(process)
        assert process.was_asked and process.wait(PATIENCE_S) == -signal.SIGKILL


@pytest.mark.parametrize("is_new", [True, False])
def test_progress_line_is_cleared_as_the_console_can(calls, monkeypatch, is_new):
    class Console(io.StringIO):
        def isatty(self) -> bool:
            return True

        def fileno(self) -> int:
            return 2

    console = Console()
    calls._KERNEL.is_console_new = is_new
    monkeypatch.setattr(progress_line, "_own_stream", lambda _: console)
    monkeypatch.setattr(progress_line, "shows_progress", lambda _: True)
    monkeypatch.setattr(console, "close", lambda: None)
    with progress_line.progress_line(console) as show:
        show("frame 1 of 2")
    assert ("\x1b" in console.getvalue()) == is_new
    assert "heatlens: frame 1 of 2" in console.getvalue() and console.getvalue().endswith(
        "\r\x1b[K" if is_new else "\r"
    )

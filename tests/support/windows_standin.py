"""Stand in for Windows: modules of heatlens see Python's library with the names that it has there.

It finds names, not behaviour: OpenGL, files and processes stay those of Linux, and X11's context
takes the place of Windows' own. The names are those of Python 3.11, the oldest that heatlens runs
on; those that came later are used nowhere (`repo/test_platforms.py`).
"""

import builtins
import ctypes
import os
import platform
import signal
import socket
import subprocess
import sys
import types
from collections.abc import Iterable, Mapping
from typing import Any

from support.windows_kernel import Kernel, Locks
from support.windows_names import LACKING, LACKING_BEFORE_3_12, MISSING_MODULES

_real_import = builtins.__import__


class Partial(types.ModuleType):
    """A module that lacks some names of the real one, and has others instead."""

    def __init__(self, real: types.ModuleType, lacks: Iterable[str] = (), **has: object) -> None:
        super().__init__(real.__name__)
        self.__dict__.update(_real=real, _lacks=frozenset(lacks), _has=has)

    def __getattribute__(self, name: str) -> Any:
        own = object.__getattribute__(self, "__dict__")
        if name in ("__dict__", "__class__"):
            return object.__getattribute__(self, name)
        if name in own["_has"]:
            return own["_has"][name]
        if name in own["_lacks"]:
            raise AttributeError(f"module {own['_real'].__name__!r} has no attribute {name!r}")
        return getattr(own["_real"], name)

    def __setattr__(self, name: str, value: object) -> None:
        setattr(self.__dict__["_real"], name, value)


class GroupPopen(subprocess.Popen):
    """Starts a process whatever flags of Windows it is given."""

    def __init__(self, *words: Any, creationflags: int = 0, **options: Any) -> None:
        super().__init__(*words, **options)


def modules_of_windows() -> dict[str, types.ModuleType]:
    """Return what the modules of Python's library are there, by name."""
    os_lacks = LACKING["os"] | LACKING_BEFORE_3_12["os"]
    libraries = {"WinDLL": Kernel, "WinError": OSError, "get_last_error": lambda: 0}
    flags = {"CREATE_NEW_PROCESS_GROUP": 0x200, "BELOW_NORMAL_PRIORITY_CLASS": 0x4000}
    signals = {"SIGBREAK": signal.SIGUSR1, "CTRL_C_EVENT": 0, "CTRL_BREAK_EVENT": signal.SIGUSR1}
    return {
        "os": Partial(os, os_lacks, name="nt"),
        "sys": Partial(sys, platform="win32"),
        "signal": Partial(signal, LACKING["signal"], **signals),
        "socket": Partial(socket, LACKING["socket"]),
        "subprocess": Partial(subprocess, Popen=GroupPopen, **flags),
        "platform": Partial(platform, system=lambda: "Windows"),
        "ctypes": Partial(ctypes, **libraries),
        "msvcrt": Locks(),
    }


def install() -> None:
    """Hand these modules to whatever heatlens imports in this process."""
    hand_out(modules_of_windows(), MISSING_MODULES)


def hand_out(swaps: Mapping[str, types.ModuleType], missing: frozenset[str]) -> None:
    """Let modules of heatlens import these in place of the real ones, and not the missing ones."""

    def import_there(
        name: str,
        globals: Mapping[str, Any] | None = None,
        locals: Mapping[str, Any] | None = None,
        fromlist: tuple[str, ...] | None = (),
        level: int = 0,
    ) -> types.ModuleType:
        importer = str((globals or {}).get("__name__", ""))
        if importer.startswith("heatlens") and level == 0:
            if name.partition(".")[0] in missing:
                raise ModuleNotFoundError(f"No module named {name!r}", name=name)
            if name in swaps:
                return swaps[name]
        if importer == "glcontext" and "egl" in (fromlist or ()):
            raise ImportError("cannot import name 'egl' from 'glcontext'")
        return _real_import(name, globals, locals, fromlist or (), level)

    builtins.__import__ = import_there

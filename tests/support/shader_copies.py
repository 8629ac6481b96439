"""A copy of the shaders, to be edited while programs built from them run."""

import os
import shutil
import weakref
from pathlib import Path

import pytest

from heatlens.core.base.paths import data_dir
from heatlens.render.gpu.shader_reload import VARIABLE


def reloading_copy(folder: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Copy the shaders to `folder`, build programs from there, and switch reloading on."""
    shutil.copytree(data_dir("shaders"), folder)
    for module in ("program", "shader_reload"):
        monkeypatch.setattr(f"heatlens.render.gpu.{module}.data_dir", lambda _: folder)
    monkeypatch.setattr("heatlens.render.gpu.shader_reload._watched", weakref.WeakSet())
    monkeypatch.setenv(VARIABLE, "1")
    return folder


def edit_shader_file(path: Path, old: str, new: str) -> None:
    """Replace `old` by `new` in a file, and set its time 1 s later, as disk times are coarse."""
    time_before, text = path.stat().st_mtime_ns, path.read_text()
    assert old in text
    path.write_text(text.replace(old, new))
    os.utime(path, ns=(time_before + 10**9, time_before + 10**9))

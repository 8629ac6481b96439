"""Copies of the program that a test edits, to add fields, enum members or GLSL."""

import os
import shutil
import subprocess
import sys
import textwrap
from pathlib import Path

import heatlens
from heatlens.core.base.paths import data_dir

_BEGIN = """
import sys
from pathlib import Path
import heatlens
folder = Path(sys.argv[1])
assert Path(heatlens.__file__).is_relative_to(folder.parent), heatlens.__file__
"""


def copy_program(top: Path, edits: dict[str, dict[str, str]]) -> Path:
    """Copy the program into `top` and apply `edits` (file: {old: new}). Return `top`."""
    shutil.copytree(Path(heatlens.__file__).parent, top / "app/heatlens")
    shutil.copytree(data_dir("shaders"), top / "shaders")
    (top / "assets").symlink_to(data_dir("assets"))
    (top / "work").mkdir()
    for name, changes in edits.items():
        text = (top / name).read_text()
        for old, new in changes.items():
            assert old in text, f"{name} has no longer {old!r}"
            text = text.replace(old, new)
        (top / name).write_text(text)
    return top


def run_in_copy(copy: Path, program: str) -> subprocess.CompletedProcess[str]:
    """Run the Python text `program` with a copy of heatlens. Return the finished process."""
    paths = str(copy / "app"), str(Path(__file__).parents[1])
    process = subprocess.run(
        [sys.executable, "-c", _BEGIN + textwrap.dedent(program), str(copy / "work")],
        capture_output=True,
        text=True,
        check=False,
        cwd=copy / "work",
        env=os.environ | {"PYTHONPATH": os.pathsep.join(paths)},
    )
    assert process.returncode == 0, process.stderr
    return process

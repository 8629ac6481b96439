"""Command lines that start heatlens again as another process.

Nothing else names the Python of this process (`tests/repo/test_platforms.py`). In the frozen
program, which needs no Python (`app/frozen/`), that is the program itself. It runs a module of
heatlens for the same first words as Python: `-P -m MODULE` (`app/frozen/program.py`).
"""

import os
import sys
from typing import NoReturn


def is_frozen() -> bool:
    """Return whether this is the frozen program, to which pip can add nothing."""
    return bool(getattr(sys, "frozen", False))


def own_command(*words: str) -> list[str]:
    """Return the command line that runs heatlens with these words."""
    return module_command("heatlens", *words)


def module_command(module: str, *words: str) -> list[str]:
    """Return the command line that runs a module of heatlens as a program."""
    # -P: a file in the current folder that has the name of a Python module must not be run.
    return [sys.executable, "-P", "-m", module, *words]


def restart_python(*options: str) -> NoReturn:
    """Run the command line of this process again in its place, with more options of Python.

    The frozen program takes none, and does without: it always has UTF-8 file names, because
    `app/frozen/heatlens.spec` gives its Python `-X utf8`.
    """
    os.execv(sys.executable, [sys.executable, *options, *sys.orig_argv[1:]])

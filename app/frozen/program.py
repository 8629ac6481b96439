"""The program of the frozen folder: `heatlens WORDS`, or `heatlens -P -m MODULE WORDS`.

The second form is how heatlens starts a module of its own as a process (`own_command.py`).
"""

import os
import runpy
import sys

import heatlens.__main__  # noqa: F401  handles Ctrl-C from the first moment on
from heatlens.fronts.commands.launch import main


def free_other_programs() -> None:
    """Take the folder's own libraries out of the environment that other programs inherit.

    PyInstaller's loader adds them to LD_LIBRARY_PATH, and saves the value of the user. This process
    has read the variable already; `--after-export` and the file dialog start programs that would
    load libraries of another version.
    """
    saved = os.environ.pop("LD_LIBRARY_PATH_ORIG", "")
    if saved:
        os.environ["LD_LIBRARY_PATH"] = saved
    else:
        os.environ.pop("LD_LIBRARY_PATH", None)


def run() -> int:
    """Run the module that the first words name, otherwise the command line of heatlens."""
    program, *words = sys.argv
    if words[:2] != ["-P", "-m"]:
        return main()
    sys.argv = [program, *words[3:]]
    if words[2] != "heatlens":
        runpy.run_module(words[2], run_name="__main__", alter_sys=True)
        return 0
    return main()


free_other_programs()
sys.exit(run())

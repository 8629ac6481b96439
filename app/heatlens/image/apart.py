"""A call in a process of its own, for libraries that a damaged file brings to an end.

Run as a module it calls the function that its arguments name, and writes what became of it to its
standard output for the process that asked.
"""

import importlib
import os
import pickle
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

import heatlens
from heatlens.errors import InputError

Result = TypeVar("Result")

_FAILED = 1  # Python's code for an error that nobody has caught


def called_apart(read: Callable[[str], Result], text: str, why_ended: str) -> Result:
    """`read(text)`, a function of a module of this package; what it gives must be picklable.

    Raises the InputError that it raises, and one that says `why_ended` where its process ends.
    """
    # -P: a file beside the user's that is called like one of Python's must not be run.
    command = [sys.executable, "-P", "-m", __spec__.name, read.__module__, read.__name__, text]
    done = subprocess.run(command, capture_output=True, env=_environment(), check=False)
    if done.returncode == _FAILED:
        raise RuntimeError(done.stderr.decode(errors="replace"))
    if done.returncode:
        raise InputError(why_ended)
    outcome: Result | InputError = pickle.loads(done.stdout)
    if isinstance(outcome, InputError):
        raise outcome
    return outcome


def _environment() -> dict[str, str]:
    """The one of this process, with the way to this very package."""
    paths = [str(Path(heatlens.__file__).parents[1]), os.environ.get("PYTHONPATH", "")]
    return os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, paths))}


def _outcome(module: str, name: str, text: str) -> object:
    """What the function gives, or the InputError that it raises."""
    try:
        return getattr(importlib.import_module(module), name)(text)
    except InputError as error:
        return error


if __name__ == "__main__":
    sys.stdout.buffer.write(pickle.dumps(_outcome(*sys.argv[1:])))

"""Whose depth networks are run: those that the user named, or agreed to.

onnxruntime runs a network as it would run a program: it takes the time and the memory that its
author wants. A shot names a network by itself, and shots come from anywhere. So a network runs if
its name was typed, for this time and all later ones, if the user says yes at the terminal, or if
`--run-networks` allows those of shots. Remembered is the content, not the name.
"""

import hashlib
import json
import os
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

from heatlens.core.base.errors import InputError
from heatlens.core.base.paths import file_bytes, preferences_dir
from heatlens.media.files.atomic_file import FOR_THE_USER, write_whole

_ALL = "HEATLENS_RUN_NETWORKS"  # also for the processes that this one starts
_MOST_BYTES = 1_000_000  # of the file of remembered networks
_asked: list[Callable[[str], bool]] = []


def key_of(path: Path) -> str:
    """Return what changes with the content of a network. Raises OSError."""
    return hashlib.blake2b(file_bytes(path), digest_size=16).hexdigest()


def run_all() -> None:
    """Let the networks of all shots run, in this process and in those that it starts."""
    os.environ[_ALL] = "1"


def ask_with(question: Callable[[str], bool]) -> None:
    """Ask the user with `question`, which takes a sentence, before a network of a shot is run."""
    _asked[:] = [question]


def trust(path: str | os.PathLike[str] | None) -> None:
    """Remember that the user named the network at `path`; one that cannot be read is told later."""
    with suppress(OSError):
        if path is not None:
            _remember(key_of(Path(os.path.expanduser(path))))


def check_trusted(path: Path, key: str) -> None:
    """Raise InputError for a network that the user neither named nor agreed to."""
    if os.environ.get(_ALL) == "1" or key in _remembered():
        return
    words = f"The shot estimates its depth with the network {path}, which runs like a program."
    if _asked and _asked[0](f"{words} Run it?"):
        _remember(key)
        return
    raise InputError(
        f"{words} If you know whose it is, give --depth-model {path} once, or --run-networks."
    )


def _file() -> Path:
    return preferences_dir() / "networks.json"


def _remembered() -> list[str]:
    with suppress(OSError, ValueError, RecursionError):
        stored = json.loads(file_bytes(_file(), _MOST_BYTES))
        return [key for key in stored if isinstance(key, str)] if isinstance(stored, list) else []
    return []


def _remember(key: str) -> None:
    keys = _remembered()
    if key in keys:
        return
    with suppress(OSError, InputError):  # without a folder to keep it in, it is asked again
        _file().parent.mkdir(mode=0o700, parents=True, exist_ok=True)
        write_whole(_file(), json.dumps([*keys, key]).encode(), FOR_THE_USER)

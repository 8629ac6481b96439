"""Decide which depth networks may run: those that the user named, or agreed to.

onnxruntime runs a network like a program, which takes the time and the memory that its author
wants. A shot file can name a network, and shot files come from anywhere. So a network runs if the
user typed its name, now or earlier, if the user says yes at the terminal, or if `--run-networks`
allows the networks of shots. The content of a network is remembered, not its name.
"""

import hashlib
import json
import os
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

from heatlens.core.base.errors import InputError
from heatlens.core.base.paths import preferences_dir, read_file_bytes
from heatlens.media.files.atomic_file import FOR_THE_USER, write_atomically

_RUN_ALL_VARIABLE = "HEATLENS_RUN_NETWORKS"  # also for the processes that this one starts
_MOST_BYTES = 1_000_000  # of the file of remembered networks
_question_callbacks: list[Callable[[str], bool]] = []  # at most one: see `set_question`


class UnknownNetworkError(InputError):
    """A shot names a network that the user neither named nor agreed to."""


def content_key(path: Path) -> str:
    """Return a key that changes with the content of a network. Raises OSError."""
    return hashlib.blake2b(read_file_bytes(path), digest_size=16).hexdigest()


def allow_all() -> None:
    """Let the networks of all shots run, in this process and in those that it starts."""
    os.environ[_RUN_ALL_VARIABLE] = "1"


def set_question(question: Callable[[str], bool]) -> None:
    """Set the function that asks the user before a network of a shot is run.

    It takes a question and returns True for yes.
    """
    _question_callbacks[:] = [question]


def trust(path: str | os.PathLike[str] | None) -> None:
    """Remember that the user named the network at `path`.

    A network that cannot be read is skipped here, and reported when it is loaded.
    """
    with suppress(OSError):
        if path is not None:
            _remember(content_key(Path(os.path.expanduser(path))))


def check_trusted(path: Path, key: str) -> None:
    """Raise UnknownNetworkError for a network that the user neither named nor agreed to."""
    if os.environ.get(_RUN_ALL_VARIABLE) == "1" or key in _read_remembered():
        return
    warning = f"The shot estimates its depth with the network {path}, which runs like a program."
    if _question_callbacks and _question_callbacks[0](f"{warning} Run it?"):
        _remember(key)
        return
    raise UnknownNetworkError(
        f"{warning} If you trust its maker, name it once with --depth-model {path}, or allow all "
        "networks with --run-networks."
    )


def _remembered_file() -> Path:
    """Return the file with the keys of the remembered networks."""
    return preferences_dir() / "networks.json"


def _read_remembered() -> list[str]:
    """Return the keys of the remembered networks; none if the file is missing or damaged."""
    with suppress(OSError, ValueError, RecursionError):
        stored = json.loads(read_file_bytes(_remembered_file(), _MOST_BYTES))
        return [key for key in stored if isinstance(key, str)] if isinstance(stored, list) else []
    return []


def _remember(key: str) -> None:
    """Add a key to the file of remembered networks, unless it is there already."""
    keys = _read_remembered()
    if key in keys:
        return
    with suppress(OSError, InputError):  # if it cannot be written, the user is asked again
        _remembered_file().parent.mkdir(mode=0o700, parents=True, exist_ok=True)
        write_atomically(_remembered_file(), json.dumps([*keys, key]).encode(), FOR_THE_USER)

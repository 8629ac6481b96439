"""Where shaders and assets lie: beside the package (wheel) or at the top of a checkout."""

import os
from pathlib import Path

from heatlens.errors import InputError

_PACKAGE = Path(__file__).resolve().parent


def home_dir() -> Path:
    """The user's home; the root of all folders for a user who has none, as in a container."""
    home = os.path.expanduser("~")
    return Path(os.sep if home == "~" else home)


def data_dir(name: str) -> Path:
    """The folder `shaders` or `assets`. importlib.resources cannot see a checkout's top level."""
    for parent in (_PACKAGE, _PACKAGE.parents[1]):
        if (parent / name).is_dir():
            return parent / name
    raise InputError(
        f"heatlens is not installed whole: no folder {name!r} beside {_PACKAGE} or two folders up. "
        "Install it again with pip."
    )

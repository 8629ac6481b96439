"""PyAV, imported when a movie is written: frames are exported without it."""

import importlib
from types import ModuleType

from heatlens.errors import InputError


def av() -> ModuleType:
    """Return the module av. Raises InputError with what to install."""
    try:
        return importlib.import_module("av")
    except ImportError as error:
        raise InputError(
            f"PyAV, which writes movies, cannot be loaded ({error}). Install it with: "
            "pip install 'heatlens[movie]'. PNG and EXR frames do not need it."
        ) from error

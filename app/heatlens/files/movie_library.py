"""Import PyAV, which is needed only for movies."""

import importlib
from types import ModuleType

from heatlens.base.errors import InputError


def av() -> ModuleType:
    """Return the module av. Raises InputError that says what to install."""
    try:
        return importlib.import_module("av")
    except ImportError as error:
        raise InputError(
            f"PyAV, which reads and writes movies, cannot be loaded ({error}). Install it with: "
            "pip install 'heatlens[movie]'. PNG and EXR frames do not need it."
        ) from error

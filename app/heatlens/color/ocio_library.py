"""OpenColorIO, imported when first asked for: pictures can be seen without it."""

import importlib
from types import ModuleType

from heatlens.errors import InputError


def ocio() -> ModuleType:
    """Return the module PyOpenColorIO; raise InputError with what to install."""
    try:
        return importlib.import_module("PyOpenColorIO")
    except ImportError as error:
        raise InputError(
            f"OpenColorIO cannot be loaded ({error}). Install it with: pip install opencolorio"
        ) from error

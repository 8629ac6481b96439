"""Import OpenColorIO, which converts colours."""

import importlib
from types import ModuleType

from heatlens.base.errors import InputError


def ocio() -> ModuleType:
    """Import PyOpenColorIO, without which pictures can still be shown with the sRGB curve.

    Raises InputError that says what to install.
    """
    try:
        return importlib.import_module("PyOpenColorIO")
    except ImportError as error:
        raise InputError(
            f"OpenColorIO cannot be loaded ({error}). Install it with: pip install opencolorio"
        ) from error

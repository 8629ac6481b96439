"""Import on first use: packages that may be missing, and modules that few commands need."""

import importlib
from dataclasses import dataclass
from importlib import import_module
from types import ModuleType
from typing import Any

from heatlens.base.errors import InputError


def import_extra(module: str, purpose: str, extra: str) -> ModuleType:
    """Import a package of an extra, such as "flip_evaluator" of the extra "compare".

    `purpose` begins the sentence of the InputError for a package that cannot be imported.
    """
    try:
        return importlib.import_module(module)
    except ImportError as error:
        raise InputError(
            f"{purpose} needs the package {module.partition('.')[0]}, which cannot be imported "
            f"({error}). Install it with: pip install 'heatlens[{extra}]'"
        ) from error


@dataclass(frozen=True)
class OnUse:
    """A function or class of another module, which is imported when it is called."""

    module: str
    name: str

    @property
    def found(self) -> Any:
        """The function or class itself."""
        return getattr(import_module(f"heatlens.{self.module}"), self.name)

    def __call__(self, *args: Any) -> Any:
        return self.found(*args)


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

"""OpenUSD, imported when first asked for: everything else works without it."""

import importlib
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

from heatlens.errors import InputError
from heatlens.image.apart import called_apart

Result = TypeVar("Result")


def usd_module(name: str) -> Any:
    """The module `name` of OpenUSD, as Usd or UsdGeom; raises InputError with what to install."""
    try:
        return importlib.import_module(f"pxr.{name}")
    except ImportError as error:
        raise InputError(
            f"OpenUSD cannot be loaded ({error}). Install it with: pip install usd-core"
        ) from error


def read_usd_apart(read: Callable[[str], Result], text: str, path: Path | str) -> Result:
    """`read(text)` of the file at `path`, in a process that a damaged file may end.

    Raises InputError where it cannot be read.
    """
    ended = f"{path} cannot be read: it is damaged in a way that ends OpenUSD."
    return called_apart(read, text, ended)

"""OpenUSD, imported when first asked for: everything else works without it."""

import importlib
import re
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, TypeVar

from heatlens.errors import InputError
from heatlens.files.apart import called_apart

Result = TypeVar("Result")


def usd_module(name: str) -> Any:
    """Return the module `name` of OpenUSD, as Usd or UsdGeom.

    Raises InputError with what to install.
    """
    try:
        return importlib.import_module(f"pxr.{name}")
    except ImportError as error:
        raise InputError(
            f"OpenUSD cannot be loaded ({error}). Install it with: pip install usd-core"
        ) from error


@contextmanager
def usd_failures_told(path: Path | str) -> Iterator[None]:
    """Raise InputError for whatever OpenUSD says of a damaged file, wherever it says it.

    A value of another kind than its name promises is found out where it is used.
    """
    errors = usd_module("Tf")
    try:
        yield
    except (
        *(errors.ErrorException, errors.CppException),
        *(TypeError, ValueError, ArithmeticError, RuntimeError),
    ) as error:
        words = " ".join(str(error).split())
        reason = re.search(r" : '(.*)'$", words)  # behind the place in OpenUSD's own source
        said = (reason[1] if reason else words)[:120]
        raise InputError(f"{path} is damaged: OpenUSD cannot parse it ({said}).") from error


def read_usd_apart(read: Callable[[str], Result], text: str, path: Path | str) -> Result:
    """Call `read(text)` for the file at `path`, in a process that a damaged file may end.

    Raises InputError where it cannot be read within its bounds on time and memory.
    """
    return called_apart(read, text, str(path))

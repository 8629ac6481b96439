"""OpenUSD, imported when first asked for: everything else works without it."""

import importlib
import re
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, TypeVar

from heatlens.errors import InputError
from heatlens.files.apart import called_apart
from heatlens.files.limits import allow_for
from heatlens.paths import unreadable

Result = TypeVar("Result")

# Of a type of C++ that Python does not know: only a file can bring one up.
_STRANGE_VALUE = re.compile(r"C\+\+ (type|object)|to_python")


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

    Other errors pass: they are mistakes of heatlens. `usd_values` refuses a value of another kind
    than its name promises.
    """
    errors = usd_module("Tf")
    try:
        yield
    except (
        *(errors.ErrorException, errors.CppException),
        *(RuntimeError, TypeError, UnicodeDecodeError),
    ) as error:
        if isinstance(error, TypeError) and not _STRANGE_VALUE.search(str(error)):
            raise
        words = " ".join(str(error).split())
        reason = re.search(r" : '(.*)'$", words)  # behind the place in OpenUSD's own source
        said = (reason[1] if reason else words)[:120]
        raise InputError(f"{path} is damaged: OpenUSD cannot parse it ({said}).") from error


def open_usd(path: Path) -> Any:
    """Open the stage at `path`. Raises InputError for what is no stage, is damaged or not there."""
    usd, errors = usd_module("Usd"), usd_module("Tf")
    if not path.is_file():
        raise unreadable(path)
    try:
        layers = _layers(path)
        stage = usd.Stage.Open(str(path))
    except errors.ErrorException as error:
        raise InputError(f"{path} cannot be read: it is damaged or not a USD file.") from error
    del layers  # the stage holds those that it is made of
    return stage


def _layers(path: Path) -> list[Any]:
    """Open every layer that the file is made of; each adds to the time allowed for all.

    Raises InputError where one is a pipe or a device, which may never end.
    """
    sdf, errors, resolver = usd_module("Sdf"), usd_module("Tf"), usd_module("Ar").GetResolver()
    allow_for(path)
    found = [sdf.Layer.FindOrOpen(str(path))]
    known = {str(path)}
    for layer in found:  # which grows meanwhile
        for asset in layer.GetCompositionAssetDependencies() if layer else ():
            name = sdf.ComputeAssetPathRelativeToLayer(layer, asset) if asset else ""
            if name and name not in known:
                known.add(name)
                check_asset(path, resolver.Resolve(name).GetPathString())
                with suppress(errors.ErrorException):  # what is built of them tells it
                    found.append(sdf.Layer.FindOrOpen(name))
    return found


def check_asset(stage: Path, path: str) -> None:
    """Allow time for a file that a stage names. Raises InputError where it is not a plain one."""
    if not path:
        return  # it is not there, which is told where it is missed
    file = Path(usd_module("Ar").SplitPackageRelativePathOuter(path)[0])
    if file.exists() and not file.is_file():  # a pipe or a device never ends
        raise InputError(f"{stage}: {path[:80]!r}, which it names, is not a file.")
    allow_for(file)


def read_usd_apart(read: Callable[[str], Result], text: str, path: Path | str) -> Result:
    """Call `read(text)` for the file at `path`, in a process that a damaged file may end.

    Raises InputError where it cannot be read within its bounds on time and memory.
    """
    return called_apart(read, text, str(path))

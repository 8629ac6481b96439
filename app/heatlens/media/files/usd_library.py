"""Load OpenUSD on first use, and open its stages safely; the rest of heatlens works without it.

The values in a file are checked, because attributes may hold anything.
"""

import math
import re
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from types import ModuleType
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from heatlens.core.base.errors import InputError
from heatlens.core.base.extras import import_extra
from heatlens.core.base.paths import unreadable
from heatlens.media.files.apart import called_apart
from heatlens.media.files.limits import allow_for

UsdObject = Any  # a stage, prim, attribute or value: OpenUSD has no types for Python
Result = TypeVar("Result")

# Errors about a C++ type that Python does not know: only the content of a file can cause them.
_FILM_MM, _FILM_BEYOND_MM = (3.0, 100.0), 200.0  # usual widths; no film is wider than the last
_LENS_MOST_MM = 2000.0
_STRANGE_VALUE = re.compile(r"C\+\+ (type|object)|to_python")


def usd_module(name: str) -> ModuleType:
    """Return a module of OpenUSD such as Usd or UsdGeom.

    Raises InputError that says what to install if it cannot be loaded.
    """
    return import_extra(f"pxr.{name}")


@contextmanager
def usd_failures_reported(path: Path | str) -> Iterator[None]:
    """Turn the errors that OpenUSD raises for a damaged file into InputErrors.

    Other errors pass, because they are faults of heatlens. `usd_values` refuses attributes whose
    values have the wrong type.
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
        reason = re.search(r" : '(.*)'$", words)  # follows the position in OpenUSD's source
        said = (reason[1] if reason else words)[:120]
        raise InputError(f"{path} is damaged: OpenUSD cannot parse it ({said}).") from error


def open_usd(path: Path) -> UsdObject:
    """Open the stage at `path`. Raises InputError if it is missing, damaged or no stage."""
    usd, errors = usd_module("Usd"), usd_module("Tf")
    if not path.is_file():
        raise unreadable(path)
    try:
        layers = _layers(path)
        stage = usd.Stage.Open(str(path))
    except errors.ErrorException as error:
        raise InputError(f"{path} cannot be read: it is damaged or not a USD file.") from error
    del layers  # the stage now holds the layers that it needs
    return stage


def _layers(path: Path) -> list[UsdObject]:
    """Open every layer of the file; each one extends the time limit of this process.

    Raises InputError if a layer is a pipe or a device, which may never end.
    """
    sdf, errors, resolver = usd_module("Sdf"), usd_module("Tf"), usd_module("Ar").GetResolver()
    allow_for(path)
    layers = [sdf.Layer.FindOrOpen(str(path))]
    known = {str(path)}
    for layer in layers:  # the list grows in the loop
        for asset in layer.GetCompositionAssetDependencies() if layer else ():
            name = sdf.ComputeAssetPathRelativeToLayer(layer, asset) if asset else ""
            if name and name not in known:
                known.add(name)
                check_asset(path, resolver.Resolve(name).GetPathString())
                with suppress(errors.ErrorException):  # composing the stage reports it
                    layers.append(sdf.Layer.FindOrOpen(name))
    return layers


def check_asset(stage: Path, path: str) -> None:
    """Allow time for a file that a stage names. Raises InputError if it is not a regular file."""
    if not path:
        return  # it is missing, which is reported when it is needed
    file = Path(usd_module("Ar").SplitPackageRelativePathOuter(path)[0])
    if file.exists() and not file.is_file():  # a pipe or a device never ends
        raise InputError(f"{stage}: {path[:80]!r}, which it names, is not a file.")
    allow_for(file)


def read_usd_apart(read: Callable[[str], Result], text: str, path: Path | str) -> Result:
    """Call `read(text)` for the file at `path` in another process, which it may crash.

    Raises InputError if it crashes, or exceeds its limits on time and memory.
    """
    return called_apart(read, text, str(path))


def numbers(value: object, width: int, what: str) -> NDArray[np.float32]:
    """Return an array of numbers or of tuples as (N, width) float32; None gives (0, width).

    Raises InputError that begins with `what` for anything else. Numbers too large for float32
    become infinite.
    """
    with np.errstate(over="ignore"):
        return _array(value, width, what).astype(np.float32)


def whole_numbers(value: object, what: str) -> NDArray[np.int64]:
    """Return an array of integers as (N,) int64. Raises InputError as `column` does."""
    column = _array(value, 1, what)[:, 0]
    if column.dtype.kind not in "iu" and column.size:
        raise _refusal(value, what)
    return column.astype(np.int64)


def lens_unit_mm(meters_per_unit: float, focal_length: float, aperture: float) -> float:
    """Return how many mm one unit of a camera's lens is: by USD, a tenth of the stage's unit.

    Some programs write mm on every stage. A film back of a usual size in mm, which would be larger
    than any film by USD, tells such a file.
    """
    by_usd = meters_per_unit * 100
    is_usual = _FILM_MM[0] <= aperture <= _FILM_MM[1] and 0 < focal_length <= _LENS_MOST_MM
    return 1.0 if is_usual and aperture * by_usd > _FILM_BEYOND_MM else by_usd


def lens_unit_note(what: object, meters_per_unit: float, focal_length: float) -> str:
    """Return the sentence on a lens whose unit is mm, against USD."""
    by_usd = focal_length * meters_per_unit * 100
    return (
        f"{what}: the file's lens seems to be in mm, as 3ds Max writes it, and is read so. By USD "
        f"its focal length would be {by_usd:g} mm, as the stage's unit is {meters_per_unit:g} m."
    )


def number(value: object, what: str) -> float:
    """Return a number that is not NaN. Raises InputError as `numbers` does."""
    if isinstance(value, float | int) and not math.isnan(value):
        return float(value)
    raise _refusal(value, what)


def _array(value: object, width: int, what: str) -> NDArray[UsdObject]:
    try:
        array = np.array([] if value is None else value)
        if array.dtype.kind in "biuf":
            return array.reshape(-1, width)
    except (TypeError, ValueError, OverflowError, RuntimeError) as error:
        raise _refusal(value, what) from error
    raise _refusal(value, what)


def _refusal(value: UsdObject, what: str) -> InputError:
    shown = " ".join(str(value).split())[:60]
    return InputError(f"{what} is not a number, or has the wrong count: {shown!r}.")

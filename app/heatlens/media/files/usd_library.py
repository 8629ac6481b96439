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
from heatlens.core.base.paths import unreadable_error
from heatlens.media.files.apart import call_in_process
from heatlens.media.files.limits import allow_for

UsdObject = Any  # a stage, prim, attribute or value: OpenUSD has no types for Python
Result = TypeVar("Result")

# Usual widths of film in mm, and a width that no film exceeds.
_FILM_MM, _FILM_MOST_MM = (3.0, 100.0), 200.0
_LENS_MOST_MM = 2000.0  # no lens has a longer focal length
# Errors about a C++ type that Python does not know: only the content of a file can cause them.
_STRANGE_VALUE = re.compile(r"C\+\+ (type|object)|to_python")


def usd_module(name: str) -> ModuleType:
    """Return a module of OpenUSD such as Usd or UsdGeom.

    Raises InputError that says what to install if it cannot be loaded.
    """
    return import_extra(f"pxr.{name}")


@contextmanager
def report_usd_failures(path: Path | str) -> Iterator[None]:
    """Convert the errors that OpenUSD raises for a damaged file to InputErrors.

    Other errors pass, because they are faults of heatlens. `float_array`, `integer_array` and
    `checked_number` refuse attributes whose values have the wrong type.
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
        message = " ".join(str(error).split())
        reason = re.search(r" : '(.*)'$", message)  # follows the position in OpenUSD's source
        short_reason = (reason[1] if reason else message)[:120]
        raise InputError(f"{path} is damaged: OpenUSD cannot parse it ({short_reason}).") from error


def open_usd(path: Path) -> UsdObject:
    """Open the stage at `path`. Raises InputError if it is missing, damaged or no stage."""
    usd_package, errors = usd_module("Usd"), usd_module("Tf")
    if not path.is_file():
        raise unreadable_error(path)
    try:
        layers = _layers(path)
        stage = usd_package.Stage.Open(str(path))
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
    seen_names = {str(path)}
    for layer in layers:  # the list grows in the loop
        for asset in layer.GetCompositionAssetDependencies() if layer else ():
            name = sdf.ComputeAssetPathRelativeToLayer(layer, asset) if asset else ""
            if name and name not in seen_names:
                seen_names.add(name)
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


def read_usd_in_process(read: Callable[[str], Result], text: str, path: Path | str) -> Result:
    """Call `read(text)` for the file at `path` in another process, which it may crash.

    Raises InputError if it crashes, or exceeds its limits on time and memory.
    """
    return call_in_process(read, text, str(path))


def float_array(value: object, width: int, subject: str) -> NDArray[np.float32]:
    """Return an array of numbers or of tuples as (N, width) float32; None gives (0, width).

    Raises InputError that begins with `subject` for anything else. Numbers too large for float32
    become infinite.
    """
    with np.errstate(over="ignore"):
        return _number_array(value, width, subject).astype(np.float32)


def integer_array(value: object, subject: str) -> NDArray[np.int64]:
    """Return an array of integers as (N,) int64. Raises InputError as `float_array` does."""
    column = _number_array(value, 1, subject)[:, 0]
    if column.dtype.kind not in "iu" and column.size:
        raise _number_error(value, subject)
    return column.astype(np.int64)


def lens_unit_mm(meters_per_unit: float, focal_length: float, aperture: float) -> float:
    """Return how many mm one unit of a camera's lens is: by USD, a tenth of the stage's unit.

    Some programs write mm on every stage. Such a file is recognized by a film back that has a usual
    width in mm, but would be larger than any film by USD.
    """
    usd_unit_mm = meters_per_unit * 100
    is_usual_in_mm = _FILM_MM[0] <= aperture <= _FILM_MM[1] and 0 < focal_length <= _LENS_MOST_MM
    return 1.0 if is_usual_in_mm and aperture * usd_unit_mm > _FILM_MOST_MM else usd_unit_mm


def lens_unit_note(subject: object, meters_per_unit: float, focal_length: float) -> str:
    """Return the sentence on a lens whose unit is mm, which differs from USD's rule."""
    usd_length_mm = focal_length * meters_per_unit * 100
    return (
        f"{subject}: the file's lens seems to be in mm, as 3ds Max writes it, and is read so. By "
        "USD "
        f"its focal length would be {usd_length_mm:g} mm, as the stage's unit is "
        f"{meters_per_unit:g} m."
    )


def checked_number(value: object, subject: str) -> float:
    """Return a number that is not NaN. Raises InputError as `float_array` does."""
    if isinstance(value, float | int) and not math.isnan(value):
        return float(value)
    raise _number_error(value, subject)


def _number_array(value: object, width: int, subject: str) -> NDArray[UsdObject]:
    """Return numbers or tuples as (N, width), of any number type. Raises InputError."""
    try:
        array = np.array([] if value is None else value)
        if array.dtype.kind in "biuf":
            return array.reshape(-1, width)
    except (TypeError, ValueError, OverflowError, RuntimeError) as error:
        raise _number_error(value, subject) from error
    raise _number_error(value, subject)


def _number_error(value: UsdObject, subject: str) -> InputError:
    """Return the error for a value that is not the number or vector expected."""
    value_text = " ".join(str(value).split())[:60]
    return InputError(f"{subject} is not a number, or has the wrong count: {value_text!r}.")

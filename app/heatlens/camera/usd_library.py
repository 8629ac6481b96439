"""OpenUSD, imported when first asked for: everything else works without it."""

import importlib
from typing import Any

from heatlens.errors import InputError

METERS_PER_UNIT = 0.01  # what USD takes for granted: focal lengths and apertures are in mm then


def usd_module(name: str) -> Any:
    """The module `name` of OpenUSD, as Usd or UsdGeom; raises InputError with what to install."""
    try:
        return importlib.import_module(f"pxr.{name}")
    except ImportError as error:
        raise InputError(
            f"OpenUSD cannot be loaded ({error}). Install it with: pip install usd-core"
        ) from error


def millimetres(meters_per_unit: float) -> float:
    """How many units of a stage's cameras are in one mm; USD counts lenses in tenths of a unit."""
    return 1e-3 / meters_per_unit * 10

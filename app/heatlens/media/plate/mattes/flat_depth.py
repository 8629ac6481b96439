"""Mend the depth of one thing: make it as flat as the thing is, inside its matte."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from heatlens.core.base.errors import InputError
from heatlens.media.plate.coc_line import no_distances
from heatlens.media.plate.mattes.mattes import LEAST_PX, SURE
from heatlens.media.plate.mattes.things import NEAREST_OF, PLANE_OF, bare_name, matte_in_frame
from heatlens.media.plate.plate import FloatImage, Plate, ReadPixels

_NEAREST_PERCENT = 98.0  # of its pixels lie behind its nearest part
_STRAY = 3.0  # medians of the distance to the plane, beyond which a pixel is left out of the fit


def with_flat_depth(plate: Plate, text: str) -> Plate:
    """Return the plate with one depth inside a matte: its median, or as a first word tells.

    `plane:` is the plane that fits most of it, `nearest:` the depth of its nearest part.

    A frame without the thing stays as it is. Raises InputError as `matte_in_frame` does, for a
    plate without distances and for one that holds its hidden surfaces.
    """
    if not plate.has_distances:
        raise no_distances(plate)
    if plate.fragments is not None:
        raise InputError(f"{plate.path} is deep: the depth of a thing cannot be flattened in it.")
    matte = matte_in_frame(plate, bare_name(text))
    if matte is None:
        return plate
    inside = matte >= SURE
    depth_m = plate.depth_m
    assert depth_m is not None
    dioptres = 1.0 / depth_m[inside].astype(np.float64)
    if len(dioptres) < LEAST_PX:
        return plate
    flat: FloatImage = depth_m.copy()
    level: float | NDArray[np.float64] = float(np.median(dioptres))
    if text.startswith(PLANE_OF):
        level = _plane(inside, dioptres)
    elif text.startswith(NEAREST_OF):
        level = float(np.percentile(dioptres, _NEAREST_PERCENT))
    with np.errstate(divide="ignore"):
        flat[inside] = 1.0 / np.maximum(level, 0.0)
    return replace(plate, pixels=ReadPixels(plate.color, flat))


def _plane(inside: NDArray[np.bool_], dioptres: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the dioptres of the plane that fits most pixels; of a plane they are linear."""
    rows, columns = np.nonzero(inside)
    places = np.stack([columns, rows, np.ones(len(rows))], axis=1)
    kept = np.ones(len(rows), bool)
    for _ in range(4):
        found = places @ np.linalg.lstsq(places[kept], dioptres[kept], rcond=None)[0]
        off = np.abs(dioptres - found)
        kept = off <= max(_STRAY * float(np.median(off)), 1e-9)
    return np.asarray(np.clip(found, dioptres.min(), dioptres.max()))

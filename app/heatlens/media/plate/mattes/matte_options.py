"""Do what options ask inside a matte: make a depth flat, or keep a thing from the blur."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from heatlens.core.base.errors import InputError
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.media.plate.coc_line import no_distances
from heatlens.media.plate.mattes.cutout import cut_out
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
    is_near = np.ones(len(rows), bool)
    for _ in range(4):
        plane = places @ np.linalg.lstsq(places[is_near], dioptres[is_near], rcond=None)[0]
        off = np.abs(dioptres - plane)
        is_near = off <= max(_STRAY * float(np.median(off)), 1e-9)
    return np.asarray(np.clip(plane, dioptres.min(), dioptres.max()))


def with_cutout(plate: Plate, options: PlateOptions) -> Plate:
    """Return the plate with what its options keep from the blur cut out.

    A frame without the thing stays as it is. Raises InputError as `matte_in_frame` does, and for a
    deep plate, whose pixels are taken apart already.
    """
    share = _share(plate, options)
    if not share.any():
        return plate
    if plate.fragments is not None and (plate.fragments.starts[:-1] & 1).any():
        raise InputError(
            f"{plate.path} is deep: nothing in it can be kept from the blur by a matte."
        )
    is_only = options.only_blur is not None
    return replace(plate, cutout=cut_out(plate.pixels, share, is_only))


def _share(plate: Plate, options: PlateOptions) -> FloatImage:
    """Return the share of each pixel that is not blurred, as at least one option asks."""
    shares: list[FloatImage] = []
    if options.never_blur is not None:
        shares.append(_matte(plate, options.never_blur))
    if options.only_blur is not None:
        shares.append(1 - _matte(plate, options.only_blur))
    share: FloatImage = np.maximum.reduce(shares)
    return share


def _matte(plate: Plate, text: str) -> FloatImage:
    matte = matte_in_frame(plate, text)
    return np.zeros(plate.color.shape[:2], np.float32) if matte is None else matte

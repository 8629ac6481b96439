"""Apply the options that act inside a matte: make a depth flat, or keep a thing from the blur."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from heatlens.core.base.errors import InputError
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.media.plate.coc_line import no_distances_error
from heatlens.media.plate.mattes.cutout import cut_out
from heatlens.media.plate.mattes.mattes import LEAST_PX, SURE_COVERAGE
from heatlens.media.plate.mattes.things import NEAREST_OF, PLANE_OF, bare_name, matte_in_frame
from heatlens.media.plate.plate import FloatImage, Plate, ReadPixels

_NEAREST_PERCENT = 98.0  # of its pixels lie behind its nearest part
_OUTLIER_FROM = (
    3.0  # medians of the distance to the plane, beyond which a pixel is left out of the fit
)


def with_flat_depth(plate: Plate, thing: str) -> Plate:
    """Return the plate with one depth inside a matte: the median of its depths.

    With the prefix `plane:` it is the plane that fits most of the depths, with `nearest:` the depth
    of the nearest part.

    A frame without the thing stays as it is. Raises InputError as `matte_in_frame` does, for a
    plate without distances and for one that holds its hidden surfaces.
    """
    if not plate.has_distances:
        raise no_distances_error(plate)
    if plate.fragments is not None:
        raise InputError(
            f"{plate.path} is deep, and --flat-depth mends the one depth of a flat picture: leave "
            "it out."
        )
    matte = matte_in_frame(plate, bare_name(thing))
    if matte is None:
        return plate
    inside = matte >= SURE_COVERAGE
    depth_m = plate.depth_m
    assert depth_m is not None
    dioptres = 1.0 / depth_m[inside].astype(np.float64)
    if len(dioptres) < LEAST_PX:
        return plate
    flat_m: FloatImage = depth_m.copy()
    flat_dioptres: float | NDArray[np.float64] = float(np.median(dioptres))
    if thing.startswith(PLANE_OF):
        flat_dioptres = _fit_plane(inside, dioptres)
    elif thing.startswith(NEAREST_OF):
        flat_dioptres = float(np.percentile(dioptres, _NEAREST_PERCENT))
    with np.errstate(divide="ignore"):
        flat_m[inside] = 1.0 / np.maximum(flat_dioptres, 0.0)
    return replace(plate, pixels=ReadPixels(plate.color, flat_m))


def _fit_plane(inside: NDArray[np.bool_], dioptres: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the dioptres (N,) of the plane that fits most pixels of a mask.

    The dioptres of a plane are a linear function of the pixel.
    """
    rows, columns = np.nonzero(inside)
    design = np.stack([columns, rows, np.ones(len(rows))], axis=1)
    is_inlier = np.ones(len(rows), bool)
    for _ in range(4):
        plane = design @ np.linalg.lstsq(design[is_inlier], dioptres[is_inlier], rcond=None)[0]
        deviation = np.abs(dioptres - plane)
        is_inlier = deviation <= max(_OUTLIER_FROM * float(np.median(deviation)), 1e-9)
    return np.asarray(np.clip(plane, dioptres.min(), dioptres.max()))


def with_cutout(plate: Plate, options: PlateOptions) -> Plate:
    """Return the plate with a cutout of the things that its options keep from the blur.

    A frame without the thing stays as it is. Raises InputError as `matte_in_frame` does, and for a
    deep plate, whose pixels are split into samples already.
    """
    share = _sharp_share(plate, options)
    if not share.any():
        return plate
    if plate.fragments is not None and plate.fragments.has_front.any():
        raise InputError(
            f"{plate.path} is deep: nothing in it can be kept from the blur by a matte."
        )
    is_only = options.only_blur is not None
    return replace(plate, cutout=cut_out(plate.pixels, share, is_only))


def _sharp_share(plate: Plate, options: PlateOptions) -> FloatImage:
    """Return the share (H, W) of each pixel that at least one option keeps from the blur."""
    shares: list[FloatImage] = []
    if options.never_blur is not None:
        shares.append(_matte_or_zeros(plate, options.never_blur))
    if options.only_blur is not None:
        shares.append(1 - _matte_or_zeros(plate, options.only_blur))
    share: FloatImage = np.maximum.reduce(shares)
    return share


def _matte_or_zeros(plate: Plate, thing: str) -> FloatImage:
    """Return the matte (H, W) of a thing; all zero if it is not in this frame."""
    matte = matte_in_frame(plate, thing)
    return np.zeros(plate.color.shape[:2], np.float32) if matte is None else matte

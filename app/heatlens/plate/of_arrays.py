"""Make a plate from arrays in memory, for notebooks and renderers."""

from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from heatlens.errors import InputError
from heatlens.model.boxes import Box
from heatlens.model.plate_options import DepthConvention, DepthKind
from heatlens.plate.plate import CameraHeader, DepthReport, FloatImage, Plate, read_pixels

_NAME = Path("array")  # appears in error messages instead of a file name


def plate_of_arrays(
    color: ArrayLike, depth_m: ArrayLike | None = None, coc_px: ArrayLike | None = None
) -> Plate:
    """Make a plate of `color` (H, W, 3 or 4), premultiplied, and a depth or CoC of shape (H, W).

    Exactly one of `depth_m`, planar metres, and `coc_px`, signed diameters in pixels, is given.
    Raises InputError for other shapes, for colours that are not finite and for depths that are not
    above 0; infinite depths mean that nothing was hit.
    """
    if (depth_m is None) == (coc_px is None):
        raise InputError("An array of colours needs either depth_m or coc_px beside it.")
    rgba = _rgba(color)
    height, width = rgba.shape[:2]
    is_coc = coc_px is not None
    values = _numbers("coc_px" if is_coc else "depth_m", coc_px if is_coc else depth_m)
    if values.shape != (height, width):
        raise InputError(f"The colours are {width}x{height}, the depth has shape {values.shape}.")
    report = _coc_report(values) if is_coc else _depth_report(values)
    window = Box(0, 0, width, height)
    return Plate(
        path=_NAME,
        pixels=read_pixels(rgba, values, is_coc),
        has_alpha=bool((rgba[..., 3] != 1).any()),
        data_window=window,
        display_window=window,
        pixel_aspect_ratio=1.0,
        camera=CameraHeader(),
        depth=report,
        aovs=(),
        attributes={},
        notes=(),
    )


def _rgba(color: ArrayLike) -> FloatImage:
    pixels = _numbers("The colours", color)
    if pixels.ndim != 3 or pixels.shape[2] not in (3, 4) or 0 in pixels.shape:
        raise InputError(f"The colours must have shape (H, W, 3) or (H, W, 4), got {pixels.shape}.")
    if not np.isfinite(pixels).all():
        raise InputError("The colours hold NaN or infinity: set these to 0 first.")
    if pixels.shape[2] == 4:
        return pixels
    opaque = np.ones((*pixels.shape[:2], 1), np.float32)
    return np.concatenate([pixels, opaque], axis=2)


def _numbers(what: str, values: ArrayLike | None) -> FloatImage:
    try:
        return np.ascontiguousarray(values, np.float32)
    except (TypeError, ValueError) as error:
        raise InputError(f"{what} cannot be read as numbers: {error}.") from error


def _depth_report(depth_m: FloatImage) -> DepthReport:
    if not (depth_m > 0).all():  # NaN fails as well
        raise InputError("depth_m holds NaN, 0 or less: a distance is above 0, or infinite.")
    finite = depth_m[np.isfinite(depth_m)]
    near, far = (float(finite.min()), float(finite.max())) if finite.size else (np.inf, np.inf)
    beyond = depth_m.size - finite.size
    why = "The caller says so."
    return DepthReport(
        "depth_m", DepthConvention.DISTANCE, DepthKind.PLANAR, why, near, far, beyond, 0
    )


def _coc_report(coc_px: FloatImage) -> DepthReport:
    if not np.isfinite(coc_px).all():
        raise InputError("coc_px holds NaN or infinity.")
    return DepthReport(
        "coc_px", DepthConvention.COC, DepthKind.PLANAR, "The caller says so.", np.nan, np.nan, 0, 0
    )

"""Make a plate from arrays in memory, for notebooks and renderers."""

from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from heatlens.core.base.errors import InputError
from heatlens.core.model.boxes import Box
from heatlens.core.model.depth_words import DepthConvention, DepthKind
from heatlens.media.plate.exr.exr_scan import check_sides
from heatlens.media.plate.plate import CameraHeader, DepthReport, FloatImage, Plate, read_pixels

_NAME = Path("array")  # appears in error messages instead of a file name


def plate_of_arrays(
    color: ArrayLike, depth_m: ArrayLike | None = None, coc_px: ArrayLike | None = None
) -> Plate:
    """Make a plate of `color` (H, W, 3 or 4), premultiplied, and a depth or CoC of shape (H, W).

    Exactly one of `depth_m`, planar meters, and `coc_px`, signed diameters in pixels, is given.
    Raises InputError for other shapes and for sizes beyond the limits, before anything is copied;
    for colors that are not floating point or not finite, masked and complex values, and depths
    that are not above 0. Infinite depths mean that nothing was hit.
    """
    colors = _convert_to_array("The colours", color)
    _check_colors(colors)
    height, width = colors.shape[:2]
    check_sides("The colours have", width, height)
    if (depth_m is None) == (coc_px is None):
        raise InputError("An array of colours needs either depth_m or coc_px beside it.")
    is_coc = coc_px is not None
    name = "coc_px" if is_coc else "depth_m"
    depth = _convert_to_array(name, coc_px if is_coc else depth_m)
    _check_numbers(name, depth, "fiu")
    if depth.shape != (height, width):
        raise InputError(
            f"The depth has shape {depth.shape}, but the colours need one of "
            f"({height}, {width}), their height and width."
        )
    rgba = _convert_to_rgba(colors)
    values = _convert_to_float32(name, depth)
    report = _report_coc(values) if is_coc else _report_depth(values)
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


def _convert_to_array(label: str, values: ArrayLike | None) -> NDArray[np.generic]:
    """Return the values as an array, without copying an array. Raises InputError."""
    try:
        return np.asanyarray(values)
    except Exception as error:  # other libraries convert their own arrays, and may raise anything
        raise InputError(f"{label} cannot be read as one array of numbers ({error}).") from error


def _check_colors(colors: NDArray[np.generic]) -> None:
    """Raise InputError for colors that are not floating point, or have another shape."""
    if colors.dtype.kind in "iub":
        raise InputError(
            f"The colours are whole numbers ({colors.dtype}), so their light is unknown: make "
            "them scene-linear floating point first (for 8-bit sRGB, divide by 255 and undo the "
            "curve), or save them as a PNG and open it with depth_source."
        )
    _check_numbers("The colours", colors, "f")
    if colors.ndim != 3 or colors.shape[2] not in (3, 4):
        raise InputError(f"The colours must have shape (H, W, 3) or (H, W, 4), got {colors.shape}.")


def _check_numbers(label: str, values: NDArray[np.generic], kinds: str) -> None:
    """Raise InputError unless the dtype's kind is among `kinds`, NumPy's kind codes."""
    if values.dtype.kind == "c":
        raise InputError(f"{label} cannot be complex numbers ({values.dtype}): give real ones.")
    if values.dtype.kind not in kinds:
        raise InputError(f"{label} cannot be read as numbers: the dtype is {values.dtype}.")


def _convert_to_rgba(colors: NDArray[np.generic]) -> FloatImage:
    """Return (H, W, 4), opaque where the colors have no alpha. Raises InputError."""
    pixels = _convert_to_float32("The colours", colors)
    if not np.isfinite(pixels).all():
        raise InputError("The colours hold NaN or infinity: set these to 0 first.")
    if pixels.shape[2] == 4:
        return pixels
    alpha = np.ones((*pixels.shape[:2], 1), np.float32)
    return np.concatenate([pixels, alpha], axis=2)


def _convert_to_float32(label: str, values: NDArray[np.generic]) -> FloatImage:
    """Return the values as float32. Raises InputError if some of them are masked."""
    if np.ma.is_masked(values):
        raise InputError(
            f"{label} cannot have masked values: fill them first, for example with filled(0) for "
            "colours and filled(numpy.inf) for depths."
        )
    with np.errstate(over="ignore"):  # values beyond float32 become infinite
        return np.ascontiguousarray(values, np.float32)


def _report_depth(depth_m: FloatImage) -> DepthReport:
    """Return the report on depths. Raises InputError for NaN, zeros and negative values."""
    if not (depth_m > 0).all():  # NaN fails as well
        raise InputError(
            "depth_m holds NaN, zeros or negative values: a distance is above 0, or infinite."
        )
    finite = depth_m[np.isfinite(depth_m)]
    near, far = (float(finite.min()), float(finite.max())) if finite.size else (np.inf, np.inf)
    infinite_count = depth_m.size - finite.size
    reason = "The caller says so."
    return DepthReport(
        channel="depth_m",
        convention=DepthConvention.DISTANCE,
        kind=DepthKind.PLANAR,
        why=reason,
        near_m=near,
        far_m=far,
        infinite_count=infinite_count,
        repaired_count=0,
    )


def _report_coc(coc_px: FloatImage) -> DepthReport:
    """Return the report on circles of confusion. Raises InputError for NaN and infinity."""
    if not np.isfinite(coc_px).all():
        raise InputError("coc_px holds NaN or infinity.")
    return DepthReport(
        channel="coc_px",
        convention=DepthConvention.COC,
        kind=DepthKind.PLANAR,
        why="The caller says so.",
        near_m=np.nan,
        far_m=np.nan,
        infinite_count=0,
        repaired_count=0,
    )

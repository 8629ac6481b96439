"""Measure how far a picture is from the truth, with established metrics."""

import contextlib
import io
import os
from dataclasses import dataclass
from types import ModuleType

import numpy as np
from numpy.typing import NDArray

from heatlens.core.base.errors import InputError
from heatlens.core.base.extras import import_extra
from heatlens.media.plate.picture.display import encode_srgb
from heatlens.media.plate.plate import FloatImage

# The PSNR of identical pictures, because the logarithm of a zero error is infinite.
PSNR_MOST_DB = 99.0
# Prevents black pixels of the truth from dominating the relative error.
_RELATIVE_FLOOR = 0.01
# Side of the window that SSIM slides over the picture.
_SSIM_SIDE_PX = 7
# Constants of SSIM for values in 0..1: (0.01)^2 and (0.03)^2, as in the paper.
_SSIM_C1, _SSIM_C2 = 1e-4, 9e-4
# Light of a truth below which the FLIP library finds no exposure and ends the process.
_DARKEST_TRUTH = 1e-6
_LUMINANCE = np.array([0.2126, 0.7152, 0.0722], np.float32)  # Rec. 709


@dataclass(frozen=True, slots=True)
class Scores:
    """Distances between a result and its truth.

    psnr_db    peak signal to noise of the display picture in dB, PSNR_MOST_DB where equal
    ssim       structural similarity of the display picture, 1 where equal (Wang et al. 2004)
    flip       mean LDR-FLIP of the display picture, 0 equal to 1 worst (Andersson et al. 2020)
    flip_hdr   mean HDR-FLIP of the light, exposures chosen from the truth (Andersson et al. 2021)
    relmse     mean of (result - truth)^2 / (truth^2 + 0.01) of the light
    nonfinite  pixels of the result that hold NaN or infinity; they count as black
    """

    psnr_db: float
    ssim: float
    flip: float
    flip_hdr: float
    relmse: float
    nonfinite: int


def score(result: FloatImage, truth: FloatImage) -> Scores:
    """Compare scene-linear RGB pictures (H, W, 3); the display picture is sRGB at exposure 0.

    Raises InputError for different sizes, for less than 7 pixels a side, and if the packages for
    the metrics are not installed.
    """
    _check_shapes(result, truth)
    nonfinite = nonfinite_count(result)
    result, truth = finite(result), finite(truth)
    display, display_truth = encode_srgb(result), encode_srgb(truth)
    return Scores(
        psnr_db=_psnr_db(display, display_truth),
        ssim=_ssim(display, display_truth),
        flip=float(flip_evaluation(display, display_truth, "LDR")[1]),
        flip_hdr=_flip_hdr(result, truth),
        relmse=_relmse(result, truth),
        nonfinite=nonfinite,
    )


def nonfinite_count(rgb: FloatImage) -> int:
    """Count the pixels of (H, W, 3) in which any channel is NaN or infinite."""
    return int(np.count_nonzero(~np.isfinite(rgb).all(axis=-1)))


def flip_library() -> ModuleType:
    """Import FLIP. Raises InputError that says what to install."""
    # Waiting threads sleep. Otherwise, on a busy machine, they would wait for each other 20 times
    # as long as they compute: a picture of 64x48 took 0.1 s of processor instead of 0.005.
    os.environ.setdefault("OMP_WAIT_POLICY", "passive")  # is read when the library is loaded
    return import_extra("flip_evaluator")


def flip_evaluation(
    result: FloatImage, truth: FloatImage, kind: str, **options: object
) -> tuple[FloatImage, float, object]:
    """Return (map, mean, parameters) of the FLIP library; `kind` is LDR (sRGB) or HDR (linear)."""
    library = flip_library()
    options = {"applyMagma": False, "inputsRGB": kind == "LDR"} | options
    with contextlib.redirect_stdout(io.StringIO()):  # some of its versions report progress there
        difference, mean, parameters = library.evaluate(truth, result, kind, **options)
    return difference, float(mean), parameters


def _check_shapes(result: FloatImage, truth: FloatImage) -> None:
    """Raise InputError if the pictures differ in size or are too small for SSIM."""
    if result.shape != truth.shape:
        raise InputError(
            "Only pictures of one size can be compared: the result is "
            f"{result.shape[1]} x {result.shape[0]} pixels, "
            f"the truth {truth.shape[1]} x {truth.shape[0]}."
        )
    if min(result.shape[:2]) < _SSIM_SIDE_PX:
        raise InputError(
            f"Pictures need {_SSIM_SIDE_PX} pixels a side to be compared; these have "
            f"{result.shape[1]} x {result.shape[0]}."
        )


def finite(rgb: FloatImage) -> FloatImage:
    """Return float32 values with NaN and infinity replaced by black."""
    return np.where(np.isfinite(rgb), rgb, 0).astype(np.float32)


def _psnr_db(display: FloatImage, display_truth: FloatImage) -> float:
    """Return the peak signal to noise ratio of display values in dB, at most PSNR_MOST_DB."""
    mean_square = float(np.mean(_error(display, display_truth) ** 2))
    return (
        PSNR_MOST_DB if mean_square == 0 else min(-10 * float(np.log10(mean_square)), PSNR_MOST_DB)
    )


def _ssim(display: FloatImage, display_truth: FloatImage) -> float:
    """Return the structural similarity (SSIM) of two display pictures (H, W, C), 1 where equal.

    It is the mean over channels and all windows of 7 x 7 pixels, with sample covariances.
    """
    a, b = display.astype(np.float64), display_truth.astype(np.float64)
    mean_a, mean_b = _window_means(a), _window_means(b)
    # n / (n - 1) for n pixels makes sample covariances of those of the window.
    sample_factor = _SSIM_SIDE_PX**2 / (_SSIM_SIDE_PX**2 - 1)
    variances = sample_factor * (
        _window_means(a * a) + _window_means(b * b) - mean_a**2 - mean_b**2
    )
    covariance = sample_factor * (_window_means(a * b) - mean_a * mean_b)
    luminance = (2 * mean_a * mean_b + _SSIM_C1) / (mean_a**2 + mean_b**2 + _SSIM_C1)
    return float(np.mean(luminance * (2 * covariance + _SSIM_C2) / (variances + _SSIM_C2)))


def _window_means(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the mean of each 7 x 7 window that lies inside; (H, W, C) to (H - 6, W - 6, C)."""
    for axis in (0, 1):
        sums = np.insert(np.cumsum(values, axis), 0, 0.0, axis)
        ends = np.arange(_SSIM_SIDE_PX, sums.shape[axis])
        values = np.take(sums, ends, axis) - np.take(sums, ends - _SSIM_SIDE_PX, axis)
    return values / _SSIM_SIDE_PX**2


def _flip_hdr(result: FloatImage, truth: FloatImage) -> float:
    """Return the mean HDR-FLIP; at exposure 0 if the truth is too dark to choose exposures."""
    result, truth = np.maximum(result, 0), np.maximum(truth, 0)
    parameters: dict[str, float] = {}
    if float((truth @ _LUMINANCE).max()) < _DARKEST_TRUTH:
        parameters = {"startExposure": 0.0, "stopExposure": 0.0}
    return float(flip_evaluation(result, truth, "HDR", parameters=parameters)[1])


def _relmse(result: FloatImage, truth: FloatImage) -> float:
    """Return the mean squared error relative to the squared light of the truth.

    _RELATIVE_FLOOR is added to the squared light.
    """
    floor = truth.astype(np.float64) ** 2 + _RELATIVE_FLOOR
    return float(np.mean(_error(result, truth) ** 2 / floor))


def _error(result: FloatImage, truth: FloatImage) -> NDArray[np.float64]:
    """Return the difference of two pictures, result - truth, in float64."""
    return result.astype(np.float64) - truth

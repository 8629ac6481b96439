"""Measure the stored numbers of a depth, by which its meaning is guessed."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from heatlens.core.base.errors import InputError
from heatlens.core.model.depth_words import DepthKind
from heatlens.media.plate.header.entries import PictureFacts
from heatlens.media.plate.plate import FloatImage

# Values from here on mean "nothing hit": 1e10 (Blender, MoonRay), FLT_MAX, 1e30, inf.
INFINITE_FROM = 1e10
# Exact values that mean the same: the far plane of Mantra and the largest half float.
INFINITE_EXACTLY = (1e6, 65504.0)
_Mask = NDArray[np.bool_]


@dataclass(frozen=True)
class DepthOrigin:
    """What is known about the source of a depth besides the channel's name.

    program  the program that wrote the file, "" if unknown
    kind     what the depth is most likely measured along
    facts     what a PNG, JPEG, TIFF or HEIC says about its depth; None for a channel of an EXR
    """

    program: str = ""
    kind: DepthKind = DepthKind.PLANAR
    facts: PictureFacts | None = None


@dataclass(frozen=True, eq=False)
class RawDepth:
    """A depth channel as stored, (H, W) float32, with statistics of its values."""

    values: FloatImage
    label: str  # "shot.exr: depth channel 'Z'", the start of every sentence about it
    channel: str
    infinite: _Mask  # an infinity that distances are marked with, of either sign
    low: float  # least and greatest of the others; NaN when there are none
    high: float
    zero_count: int
    nan_count: int
    negative_count: int
    origin: DepthOrigin

    @property
    def infinite_count(self) -> int:
        """Pixels that hold a mark of infinity."""
        return int(np.count_nonzero(self.infinite))

    @property
    def greatest_magnitude(self) -> float:
        """Greatest magnitude of the values, without marks of infinity."""
        return max(abs(self.low), abs(self.high))

    @property
    def least_magnitude(self) -> float:
        """Least magnitude of the values, without marks of infinity, if all have one sign."""
        return min(abs(self.low), abs(self.high))


def scale_white_to_one(raw: RawDepth) -> RawDepth:
    """Scale integer values so that white is 1; return floating-point values unchanged."""
    white = None if raw.origin.facts is None else raw.origin.facts.full_scale
    if white is None:
        return raw
    values = raw.values / np.float32(white)
    return replace(raw, values=values, low=raw.low / white, high=raw.high / white)


# 1e6 and 65504 mean infinity only in floating point. In a map of integers, 65504 is a depth like
# any other.
def measure_raw_depth(
    values: FloatImage, label: str, channel: str, origin: DepthOrigin
) -> RawDepth:
    """Gather statistics of the channel. Raises InputError if every value is zero or NaN."""
    magnitude = np.abs(values)
    infinite = magnitude >= INFINITE_FROM
    is_whole = origin.facts is not None and origin.facts.full_scale is not None
    for mark in () if is_whole else INFINITE_EXACTLY:
        infinite |= magnitude == mark
    finite_values = values[~infinite]
    nan_count = int(np.count_nonzero(np.isnan(finite_values)))
    if nan_count:
        finite_values = finite_values[~np.isnan(finite_values)]
    zero_count = int(finite_values.size - np.count_nonzero(finite_values))
    if zero_count + nan_count == values.size:
        content = "NaN" if zero_count == 0 else "zero or NaN" if nan_count else "zero"
        raise InputError(
            f"{label} is empty (every pixel is {content}). Was the depth pass switched on for this "
            "render? Choose another channel with --depth-channel."
        )
    low, high = (
        (float(finite_values.min()), float(finite_values.max()))
        if finite_values.size
        else (np.nan, np.nan)
    )
    negative_count = int(np.count_nonzero(finite_values < 0)) if low < 0 else 0
    return RawDepth(
        values=values,
        label=label,
        channel=channel,
        infinite=infinite,
        low=low,
        high=high,
        zero_count=zero_count,
        nan_count=nan_count,
        negative_count=negative_count,
        origin=origin,
    )

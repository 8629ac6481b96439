"""Which convention a depth channel follows, when nobody says: guessed from its name and values.

Where the values fit several conventions the guess is refused, not made: a wrong one would blur the
wrong things and look almost right.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from heatlens.errors import InputError
from heatlens.image.plate import FloatImage
from heatlens.model.plate_options import DepthConvention, PlateOptions

# At and beyond this renderers mean "nothing hit": 1e10 (Blender, MoonRay), FLT_MAX, 1e30, inf.
INFINITE_FROM = 1e10
# Exact values that mean the same: Mantra's far plane and the largest half.
INFINITE_EXACTLY = (1e6, 65504.0)

# Filtering carries a normalised depth a little past its ends.
NORMALIZED_UP_TO = 1.5

_Mask = NDArray[np.bool_]


@dataclass(frozen=True)
class Guess:
    """A convention, one sentence saying why, and whether it needs no saying aloud."""

    convention: DepthConvention  # never "auto"
    why: str
    certain: bool = True


@dataclass(frozen=True, eq=False)
class RawDepth:
    """A depth channel as stored, (H, W) float32, and what its values are like."""

    values: FloatImage
    what: str  # "shot.exr: depth channel 'Z'", the start of every sentence about it
    channel: str
    infinite: _Mask  # an infinity that distances are marked with, of either sign
    low: float  # least and greatest of the others; NaN when there are none
    high: float
    zero_count: int
    nan_count: int
    negative_count: int

    @property
    def infinite_count(self) -> int:
        """Pixels that hold a mark of infinity."""
        return int(np.count_nonzero(self.infinite))

    @property
    def top(self) -> float:
        """Greatest magnitude of the values that are no mark of infinity."""
        return max(abs(self.low), abs(self.high))


def looked_at(values: FloatImage, what: str, channel: str) -> RawDepth:
    """Count what is in the channel. Raises InputError when it is empty: all zero or all NaN."""
    magnitude = np.abs(values)
    infinite = magnitude >= INFINITE_FROM
    for mark in INFINITE_EXACTLY:
        infinite |= magnitude == mark
    plain = values[~infinite]
    nan_count = int(np.count_nonzero(np.isnan(plain)))
    if nan_count:
        plain = plain[~np.isnan(plain)]
    zero_count = int(plain.size - np.count_nonzero(plain))
    if zero_count + nan_count == values.size:
        found = "NaN" if zero_count == 0 else "zero or NaN" if nan_count else "zero"
        raise InputError(
            f"{what} is empty (every pixel is {found}). Was the depth pass switched on for this "
            "render? Another channel is taken with --depth-channel."
        )
    low, high = (float(plain.min()), float(plain.max())) if plain.size else (np.nan, np.nan)
    negative = int(np.count_nonzero(plain < 0)) if low < 0 else 0
    return RawDepth(values, what, channel, infinite, low, high, zero_count, nan_count, negative)


def guess_convention(raw: RawDepth, options: PlateOptions) -> Guess:
    """The convention of `raw`, with why.

    Raises InputError when its values fit several, naming the options that decide.
    """
    if options.depth_convention != "auto":
        return Guess(options.depth_convention, "Given with --depth-convention.")
    by_name = _guess_by_name(raw.channel)
    if by_name:
        return by_name
    if raw.infinite_count == raw.values.size:
        return Guess("distance", "Every pixel holds a mark of infinity, as only distances do.")
    has_ends = options.near_m is not None and options.far_m is not None
    if has_ends and raw.top <= NORMALIZED_UP_TO:
        return _normalized_direction(raw)
    if raw.top > 1:
        beyond = "above 1" if raw.high > 1 else "below -1"
        why = f"Its values run from {raw.low:g} to {raw.high:g}, {beyond}, so they are distances."
        if has_ends:
            return Guess("distance", f"{why} --near and --far are not used.", certain=False)
        return Guess("distance", why)
    return _guess_within_one(raw)


def _guess_by_name(channel: str) -> Guess | None:
    """What the channel's name says, if anything."""
    name = channel.lower()
    if "coc" in name or "circleofconfusion" in name:
        return Guess("coc", "Its name says circle of confusion.")
    if "dispar" in name or "inverse" in name or "invz" in name:
        return Guess("inverse", "Its name says that it holds 1/z.")
    return None


def _normalized_direction(raw: RawDepth) -> Guess:
    """Which way round a 0..1 depth runs: the end that more pixels stand at is the far one."""
    ones = int(np.count_nonzero((raw.values >= 1) & ~raw.infinite))
    zeros = int(np.count_nonzero((raw.values <= 0) & ~raw.infinite))
    convention: DepthConvention = "normalized-inverted" if zeros > ones else "normalized"
    far = "0, black" if zeros > ones else "1, white"
    return Guess(
        convention,
        f"--near and --far are given and its values lie in 0 to 1; {zeros} pixels stand at 0 and "
        f"{ones} at 1, so {far}, is taken as far: a guess, which --depth-convention overrules.",
        certain=False,
    )


def _guess_within_one(raw: RawDepth) -> Guess:
    """The convention of values no greater than 1, or a refusal."""
    span = f"{raw.low:g} to {raw.high:g}"
    if raw.infinite_count:
        return Guess(
            "distance", f"It holds marks of infinity beside values of {span}, as distances do."
        )
    if raw.low == raw.high:
        return Guess("distance", f"It is {raw.low:g} everywhere: taken as a distance.")
    if raw.zero_count and raw.top < 1:
        return Guess(
            "inverse",
            f"It is 0 in {raw.zero_count} pixels and up to {raw.high:g} elsewhere, as 1/z with 0 "
            "at infinity: a guess, which --depth-convention overrules.",
            certain=False,
        )
    raise InputError(
        f"{raw.what} holds only values from {span}, which may be a normalised depth, distances or "
        "1/z. Say which: --depth-convention normalized or normalized-inverted (1 near) with --near "
        "and --far in metres, or --depth-convention distance or inverse."
    )

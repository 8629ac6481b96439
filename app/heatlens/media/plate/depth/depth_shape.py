"""Tell from the flat surfaces of a depth channel whether it holds distances or their inverse.

For a plane seen through a pinhole, 1/z is a linear function of the pixel. Of three pixels in a
row at equal distances, the middle one holds the arithmetic mean of the outer two if the channel is
1/z, and their harmonic mean if it is z. Walls, floors and the facets of meshes vote. A surface that
faces the camera or is curved casts no vote, and neither does a channel that is a single ramp from
edge to edge, which people paint to test a lens.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from heatlens.media.plate.plate import FloatImage

# Distances in pixels between compared pixels: near surfaces are steep, far ones need more.
_STRIDES = (4, 16, 48)
_SAMPLES_MOST = 200_000  # triples for each stride and direction
# Beyond this ratio two pixels lie on different surfaces more often than on one.
_RATIO_MOST = 3.0
# A vote counts if the middle value is within this share of the way from one mean to the other.
_TOLERANCE = 0.1
_HALF_STEP, _FLOAT_STEP = 2.0**-11, 2.0**-18  # relative rounding steps of stored values
_STEPS_APART = 20.0  # the two means can be told apart if they differ by so many rounding steps
_LEAST_VOTES = 100  # fewer votes for a convention decide nothing
# Samples along each side; the greatest deviation from a plane, as a part of the range of values.
_RAMP_SAMPLES, _RAMP_PART = 16, 0.01
# The least share of the deciding triples for a majority, and its least ratio to the other votes.
_LEAST_SHARE, _LEAST_LEAD = 0.02, 5.0

_Mask = NDArray[np.bool_]


@dataclass(frozen=True)
class FlatVotes:
    """Counts of pixel triples that fit a plane if read as distances, and if read as 1/z.

    examined  number of triples that could decide
    """

    distance: int
    inverse: int
    examined: int

    @property
    def says_distance(self) -> bool:
        """True if far more triples fit a plane when the values are read as distances."""
        return self._has_majority(self.distance, self.inverse)

    @property
    def says_inverse(self) -> bool:
        """True if far more triples fit a plane when the values are read as 1/z."""
        return self._has_majority(self.inverse, self.distance)

    def _has_majority(self, votes: int, other_votes: int) -> bool:
        """Return True if `votes` are enough, and many more than `other_votes`."""
        least_votes = max(_LEAST_VOTES, _LEAST_SHARE * self.examined)
        return votes >= least_votes and votes >= _LEAST_LEAD * other_votes


# Flat surfaces tell distances from 1/z where neither the name nor the range can: meters of a table
# and 1/z of a street may both run from 0.1 to 4. The camera need not be known, because the focal
# length only scales the pixel. A few votes decide nothing: one convention needs five times as many
# as the other. A wrong convention would blur the wrong things and look almost right.
def count_flat_votes(
    values: FloatImage, infinite: NDArray[np.bool_], integer_step: float = 0.0
) -> FlatVotes:
    """Count how many flat surfaces of `values` (H, W) vary as distance, and how many as 1/distance.

    `infinite` marks pixels without a surface. `integer_step` is the rounding step of integer
    values, 0 for floating point.
    """
    magnitude = np.where(infinite | ~np.isfinite(values), 0.0, np.abs(values))
    step = _HALF_STEP if _fits_half_floats(magnitude) else _FLOAT_STEP
    distance = inverse = examined = 0
    if _is_single_ramp(magnitude):
        return FlatVotes(distance=0, inverse=0, examined=0)
    for first, middle, last in _pixel_triples(magnitude.astype(np.float64)):
        share, is_decisive = _arithmetic_share(first, middle, last, step, integer_step)
        distance += int(np.count_nonzero(is_decisive & (np.abs(share) < _TOLERANCE)))
        inverse += int(np.count_nonzero(is_decisive & (np.abs(share - 1.0) < _TOLERANCE)))
        examined += int(np.count_nonzero(is_decisive))
    return FlatVotes(distance, inverse, examined)


def _fits_half_floats(magnitude: FloatImage) -> bool:
    """Return True if the middle row of the values fits in half floats without loss."""
    row = magnitude[magnitude.shape[0] // 2]
    with np.errstate(over="ignore"):
        return bool(np.array_equal(row, row.astype(np.float16).astype(row.dtype)))


# A ramp painted from edge to edge casts no votes. It fits 1/z at every pixel, but people paint such
# ramps as distances, to test a lens.
def _is_single_ramp(magnitude: FloatImage) -> bool:
    """Return True if samples of the whole channel lie on a single linear function of the pixel."""
    rows = np.linspace(0, magnitude.shape[0] - 1, _RAMP_SAMPLES).astype(int)
    columns = np.linspace(0, magnitude.shape[1] - 1, _RAMP_SAMPLES).astype(int)
    y, x = (grid.ravel() for grid in np.meshgrid(rows, columns, indexing="ij"))
    values = magnitude[y, x].astype(np.float64)
    design = np.stack([np.ones(len(x)), x, y], axis=1)
    plane = design @ np.linalg.lstsq(design, values, rcond=None)[0]
    return bool(np.abs(values - plane).max() <= _RAMP_PART * np.ptp(values))


def _pixel_triples(
    values: NDArray[np.float64],
) -> Iterator[tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]]:
    """Yield arrays with the first, middle and last value of triples of pixels.

    The triples run along x and along y, for every stride. Lines are left out so that at most about
    _SAMPLES_MOST triples are examined each time.
    """
    for plane in (values, values.T):
        for stride in _STRIDES:
            if plane.shape[1] <= 2 * stride:
                continue
            kept_rows = plane[:: max(1, plane.size // _SAMPLES_MOST)]
            yield (
                kept_rows[:, : -2 * stride],
                kept_rows[:, stride:-stride],
                kept_rows[:, 2 * stride :],
            )


# Only triples count whose two means lie many rounding steps apart. The means are almost equal where
# a surface is far or faces the camera: there the rounding of half floats, or of a PNG, would decide
# which one the middle value meets.
def _arithmetic_share(
    first: NDArray[np.float64],
    middle: NDArray[np.float64],
    last: NDArray[np.float64],
    step: float,
    integer_step: float,
) -> tuple[NDArray[np.float64], _Mask]:
    """Return the position of the middle value between two means, and a mask of decisive triples.

    The position is 0 on the harmonic mean and 1 on the arithmetic mean of `first` and `last`.
    `step` is the relative rounding step of the values, `integer_step` the absolute one.
    """
    is_surface = (first > 0) & (middle > 0) & (last > 0)
    total = np.where(is_surface, first + last, 1.0)
    harmonic, arithmetic = 2 * first * last / total, total / 2
    mean_difference = arithmetic - harmonic
    is_decisive = is_surface & (
        mean_difference > _STEPS_APART * np.maximum(step * arithmetic, integer_step)
    )
    is_decisive &= np.maximum(first, last) < _RATIO_MOST * np.minimum(first, last)
    share = (middle - harmonic) / np.where(is_decisive, mean_difference, 1.0)
    return share, is_decisive

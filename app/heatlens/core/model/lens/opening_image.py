"""A picture used as the lens opening: its light on a grid, in NumPy.

The square picture is the box around the round opening of the same f-stop. A lamp behind the focus
shows it upright. Cells outside the circle are dark, because there is no glass. Points are those of
`core/model/lens/opening.py`. The light is relative to its mean over the circle, so that neither a
dark picture nor a small shape changes the exposure.

shaders/lib/opening_image.lib.glsl has the same functions;
tests/render/defocus/test_opening_image.py compares the two. Both read one table: the sums of the
light over the cells above and to the left of each corner (Crow 1984), in whole numbers, so that
differences are exact. It yields the mean over any box, and sample points by inversion of the
cumulative sums.
"""

import math
from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike, NDArray

from heatlens.core.base.errors import LensError
from heatlens.core.model.lens.opening import Barrel, past_barrel, profile

IMAGE_SIDE = 256  # cells of the grid, each way
# How finely the shift of the barrel is tabulated: steps from 0 to the most on one side.
BARREL_STEPS = 8
_WHITE = 2**15 - 1  # value of the brightest cell: the sum of all cells stays below 2^31
_ROTATION_SAMPLES = 3  # samples of a cell, each way, where the picture is turned
_BELOW_ONE = 1.0 - 1e-6  # largest number of a square that is looked up in the sums
_BARREL_TABLE_CELLS = 8  # cells of the grid, each way, for one cell of the barrel's table

Array = NDArray[np.float64]
Pair = tuple[float, float]


@dataclass(frozen=True, slots=True)
class OpeningImage:
    """The picture of an opening, as read from its file.

    path    of the file, shown to people
    digest  of the light; "" where the file was not read
    light   (IMAGE_SIDE, IMAGE_SIDE) float32, 0 or more, rows from the top; None if the file was
            not read
    notes   sentences on how it was read
    """

    path: str
    digest: str = ""
    light: NDArray[np.float32] | None = field(default=None, compare=False, repr=False)
    notes: tuple[str, ...] = field(default=(), compare=False)

    def grid(self, rotation_deg: float = 0.0) -> "ImageGrid":
        """Return the opening that the picture makes, turned anticlockwise.

        Raises LensError if the file was not read.
        """
        return _grid(self, math.remainder(rotation_deg, 360.0))


@dataclass(frozen=True, slots=True, eq=False)
class ImageGrid:
    """The light of an opening.

    sums  (IMAGE_SIDE + 1, IMAGE_SIDE + 1) whole numbers: the light of all cells above and to the
          left of a corner
    """

    sums: NDArray[np.int64]

    @property
    def scale(self) -> float:
        """The scale from a cell's number to light whose mean over the circle is 1."""
        return math.pi * IMAGE_SIDE**2 / 4 / float(self.sums[-1, -1])

    @property
    def cells(self) -> Array:
        """(IMAGE_SIDE, IMAGE_SIDE) light, rows from the top."""
        return np.asarray(np.diff(np.diff(self.sums, axis=0), axis=1) * self.scale, np.float64)

    def cover(self, x: ArrayLike, y: ArrayLike, half_sides: Pair) -> Array:
        """Return the mean light in boxes around the points (x, y), of the arguments' shape.

        `half_sides` are half the width and height of a box in radii. A box is at least as large
        as a cell, which interpolates between cells, so that a large disc shows no steps.
        """
        column, row = _grid_position(np.asarray(x, np.float64), np.asarray(y, np.float64))
        half_x, half_y = (max(half * IMAGE_SIDE / 2, 0.5) for half in half_sides)
        above, below = row - half_y, row + half_y
        left, right = column - half_x, column + half_x
        total = (
            self._sum_to(right, below)
            - self._sum_to(left, below)
            - self._sum_to(right, above)
            + self._sum_to(left, above)
        )
        return np.asarray(np.maximum(total, 0.0) * (self.scale / (4 * half_x * half_y)))

    # Whole numbers stay exact in the table: in float32, the sum over a small box would be the
    # difference of two large sums, and lose its digits.
    def _sum_to(self, column: Array, row: Array) -> Array:
        """Return the light above a row and to the left of a column; both may be fractional."""
        (i, fraction_x), (j, fraction_y) = (
            _split_cell(np.clip(coordinate, 0.0, float(IMAGE_SIDE))) for coordinate in (column, row)
        )
        upper = (1 - fraction_x) * self.sums[j, i] + fraction_x * self.sums[j, i + 1]
        lower = (1 - fraction_x) * self.sums[j + 1, i] + fraction_x * self.sums[j + 1, i + 1]
        return np.asarray((1 - fraction_y) * upper + fraction_y * lower)

    # Points are found by inversion and not by rejection: every number of an even sequence becomes a
    # point, so that the points cover the opening as evenly, and dark cells cost nothing.
    def points(self, square: Array) -> Array:
        """Return the points (n, 2) that belong to `square` (n, 2) in [0, 1)^2.

        Equal areas of the square become parts of the opening with equal light. The second number
        selects the row, then the first the position in it.
        """
        target_x, target_y = np.minimum(square, _BELOW_ONE).T
        rows = self.sums[:, -1].astype(np.float64)
        row, fraction_y = _invert_sums(rows[None], target_y)
        row_sums = (self.sums[row + 1] - self.sums[row]).astype(np.float64)
        column, fraction_x = _invert_sums(row_sums, target_x)
        x = (column + fraction_x) * 2 / IMAGE_SIDE - 1
        return np.stack([x, 1 - (row + fraction_y) * 2 / IMAGE_SIDE], axis=-1)

    def light(self, barrel: Barrel | None, rim: float) -> float:
        """Return the integral of the light with a rim that is bright or soft, in square radii.

        It is pi for a flat rim without a barrel.
        """
        light = self._light_with_rim(rim)
        if barrel is not None:
            light = light * _barrel_coverage(barrel, IMAGE_SIDE)
        return float(light.sum()) * 4 / IMAGE_SIDE**2

    def variance(self, rim: float) -> float:
        """Return the mean square of the distance from the axis along x or y, in radii^2.

        It is 1/4 for a round opening. The axis is that of the lens and not the middle of the light,
        because the diffusion spreads light about it.
        """
        x, y = _cell_centers(IMAGE_SIDE)
        light = self._light_with_rim(rim)
        return float((light * (x**2 + y**2)).sum() / light.sum() / 2)

    # The light of an image past the barrel has no formula, and each lamp needs it for its own
    # position in the picture, so it is tabulated; by symmetry, half of the table is enough.
    def light_shares_past_barrel(self, shift_most: float, radius: float, rim: float) -> Array:
        """Return the share of the light that the barrel lets pass, by the shift of its circles.

        The shape is (2 BARREL_STEPS + 1, BARREL_STEPS + 1): rows by the shift along y from
        -shift_most on, columns by that along x from 0 on, in even steps. A shift and its reverse
        are the same.
        """
        side = IMAGE_SIDE // _BARREL_TABLE_CELLS
        light = (
            self._light_with_rim(rim)
            .reshape(side, _BARREL_TABLE_CELLS, side, _BARREL_TABLE_CELLS)
            .sum(axis=(1, 3))
        )
        light /= light.sum()
        steps = np.arange(-BARREL_STEPS, BARREL_STEPS + 1) * (shift_most / BARREL_STEPS)
        rows = [
            [
                float(np.vdot(light, _barrel_coverage(Barrel((x, y), radius), side)))
                for x in steps[BARREL_STEPS:].tolist()
            ]
            for y in steps.tolist()
        ]
        return np.array(rows)

    def _light_with_rim(self, rim: float) -> Array:
        """Return the light of the cells times the profile of a rim, -1 to 1."""
        x, y = _cell_centers(IMAGE_SIDE)
        return self.cells * profile(np.minimum(x**2 + y**2, 1.0), rim)


def light_in_circle(light: NDArray[np.float32]) -> Array:
    """Return the light (IMAGE_SIDE, IMAGE_SIDE) of a picture within the circle of the lens."""
    return np.asarray(light * _inside_circle(), np.float64)


@lru_cache(maxsize=16)
def _grid(image: OpeningImage, rotation_deg: float) -> ImageGrid:
    """Return the summed light of `image` turned anticlockwise; see `OpeningImage.grid`."""
    if image.light is None:
        raise LensError(
            f"The aperture image {image.path} could not be read: choose another PNG, "
            "JPEG, EXR or TIFF."
        )
    light = light_in_circle(_rotate_light(image.light, rotation_deg))
    numbers = np.rint(light * (_WHITE / light.max())).astype(np.int64)
    sums = np.zeros((IMAGE_SIDE + 1, IMAGE_SIDE + 1), np.int64)
    sums[1:, 1:] = numbers.cumsum(axis=0).cumsum(axis=1)
    return ImageGrid(sums)


def _rotate_light(light: NDArray[np.float32], rotation_deg: float) -> NDArray[np.float32]:
    """Return the picture turned anticlockwise, each cell the mean of finer samples."""
    if rotation_deg == 0.0:
        return light
    x, y = _cell_centers(_ROTATION_SAMPLES * IMAGE_SIDE)
    turn = math.radians(rotation_deg)
    sine, cosine = math.sin(turn), math.cos(turn)
    column, row = _grid_position(cosine * x + sine * y, cosine * y - sine * x)
    i, j = (np.clip(coordinate.astype(np.int32), 0, IMAGE_SIDE - 1) for coordinate in (column, row))
    samples = light.ravel()[j * IMAGE_SIDE + i]
    return _cell_means(samples)


@lru_cache(maxsize=1)
def _inside_circle() -> NDArray[np.float32]:
    """Return the share of each cell inside the unit circle."""
    x, y = _cell_centers(8 * IMAGE_SIDE)
    return _cell_means((x**2 + y**2 <= 1.0).astype(np.float32))


def _cell_means(samples: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return the means of the samples of each cell."""
    samples_per_side = len(samples) // IMAGE_SIDE
    parts = [
        samples[j::samples_per_side, i::samples_per_side]
        for j in range(samples_per_side)
        for i in range(samples_per_side)
    ]
    return np.asarray(sum(parts) / np.float32(samples_per_side**2), np.float32)


def _barrel_coverage(barrel: Barrel, side: int) -> Array:
    """Return the share of each of `side` x `side` cells that a barrel lets through."""
    x, y = _cell_centers(side)
    past = past_barrel(x, y, barrel)[0]
    return np.asarray(np.clip(0.5 - past * side / 2, 0.0, 1.0))


def _cell_centers(side: int) -> tuple[Array, Array]:
    """Return x (1, side) and y (side, 1) of the middles of cells, rows from the top."""
    centers = (np.arange(side) + 0.5) * 2 / side - 1
    return centers[None, :], -centers[:, None]


def _grid_position(x: Array, y: Array) -> tuple[Array, Array]:
    """Return column and row of points, in cells from the upper left corner."""
    return (x + 1) * (IMAGE_SIDE / 2), (1 - y) * (IMAGE_SIDE / 2)


def _split_cell(position: Array) -> tuple[NDArray[np.int64], Array]:
    """Return the cell of a position, and the fraction of the cell that lies before it."""
    cell = np.minimum(position.astype(np.int64), IMAGE_SIDE - 1)
    return cell, position - cell


def _invert_sums(sums: Array, target: Array) -> tuple[NDArray[np.int64], Array]:
    """Return the cell in which each row of cumulative sums reaches the share `target` of its total.

    Also return the fraction of the cell at which it does. `sums` is (n or 1, IMAGE_SIDE + 1),
    `target` (n,) from 0 to 1.
    """
    rows = np.arange(len(target)) % len(sums)
    target_sum, cell = target * sums[:, -1], np.zeros(len(target), np.int64)
    step = IMAGE_SIDE // 2
    while step:  # bisection of all rows at once
        cell += step * (sums[rows, cell + step] <= target_sum)
        step //= 2
    low, high = sums[rows, cell], sums[rows, cell + 1]
    return cell, (target_sum - low) / (high - low)

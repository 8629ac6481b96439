"""The image of an opening in a picture: the disc that a point of light out of focus becomes.

The position in a picture counts too, for lens effects that vary towards the corners.
"""

import math
from dataclasses import dataclass, field, replace
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike, NDArray

from heatlens.core.model.lens import opening
from heatlens.core.model.lens.aperture import Aperture, shape_uniforms
from heatlens.core.model.lens.opening import FIELD_STEPS, Barrel, variances
from heatlens.core.model.lens.opening_image import BARREL_STEPS

Pair = tuple[float, float]


@dataclass(frozen=True, slots=True)
class PictureField:
    """The middle and the corners of a picture.

    middle_px         middle of the picture, from the first pixel's corner, x right and y down
    half_diagonal_px  from there to a corner, in pixels across; infinite if the position in the
                      picture has no effect
    """

    middle_px: Pair = (0.0, 0.0)
    half_diagonal_px: float = math.inf

    @staticmethod
    def of(size: tuple[int, int], pixel_aspect_ratio: float = 1.0) -> "PictureField":
        """Return the field of a whole picture of this width and height."""
        width, height = size
        return PictureField(
            (width / 2, height / 2), math.hypot(width, height / pixel_aspect_ratio) / 2
        )

    def moved(self, px: Pair) -> "PictureField":
        """Return the field of a picture that starts this many pixels farther left and up."""
        return replace(self, middle_px=(self.middle_px[0] + px[0], self.middle_px[1] + px[1]))

    def scaled(self, scale: float) -> "PictureField":
        """Return the field of the picture at another size."""
        x, y = self.middle_px
        return PictureField((x * scale, y * scale), self.half_diagonal_px * scale)

    def uniforms(self, aperture: Aperture, pixel_aspect_ratio: float = 1.0) -> dict[str, object]:
        """Return the uniforms for lib/shaped_aperture.lib.glsl."""
        shift_most = _shift_most(aperture)
        per_px = shift_most / self.half_diagonal_px
        image = aperture.aperture_image
        return {
            **({} if image is None else {"aperture_image_passed": _parts_past_barrel(aperture)}),
            "aperture_middle_px": self.middle_px,
            "aperture_shift_per_px": (per_px, -per_px / pixel_aspect_ratio),
            "aperture_shift_most": shift_most,
            "aperture_barrel": aperture.stopped_down if aperture.cat_eye else 0.0,
        }

    def diffusion_uniforms(
        self, aperture: Aperture, pixel_aspect_ratio: float = 1.0
    ) -> dict[str, object]:
        """Return the uniforms of lib/blur_system.lib.glsl, to blur as widely as the disc.

        Diffusion and disc have the same variance, which may change from the middle of the picture
        to its corners.
        """
        per_px = 1 / self.half_diagonal_px
        return {
            "field_middle_px": self.middle_px,
            "field_per_px": (per_px, per_px / pixel_aspect_ratio),
            "field_variances": field_variances(_shift_most(aperture), aperture.stopped_down),
        }

    def barrel(
        self, aperture: Aperture, position_px: Pair, pixel_aspect_ratio: float = 1.0
    ) -> Barrel | None:
        """Return the barrel as seen from a position in the picture; None if it cuts nothing."""
        if aperture.cat_eye == 0.0:
            return None
        shift_most = _shift_most(aperture)
        x = (position_px[0] - self.middle_px[0]) * shift_most / self.half_diagonal_px
        y = (
            (self.middle_px[1] - position_px[1])
            * shift_most
            / self.half_diagonal_px
            / pixel_aspect_ratio
        )
        limit = min(1.0, shift_most / max(math.hypot(x, y), 1e-30))  # constant beyond the corner
        return Barrel((x * limit, y * limit), aperture.stopped_down)


@lru_cache(maxsize=64)
def field_variances(shift: float, radius: float) -> tuple[Pair, ...]:
    """Return variances of discs at even steps from the middle of the picture to a corner.

    Each is a pair, along and across the direction to the corner, relative to a round disc's.
    `shift` and `radius` are those of the barrel's circles at the corner.
    """
    pairs = []
    for step in range(FIELD_STEPS):
        along, across = variances(Barrel((shift * step / (FIELD_STEPS - 1), 0.0), radius))
        pairs.append((4 * along, 4 * across))
    return tuple(pairs)


@lru_cache(maxsize=64)
def _parts_past_barrel(aperture: Aperture) -> list[Pair]:
    """Return the shares of light that pass the barrel, a pair for each shift of its circles.

    A pair has the shares of discs in front of and behind the focus.
    See `ImageGrid.light_shares_past_barrel` for the order of the pairs.
    """
    grid = aperture.grid
    if grid is None or aperture.cat_eye == 0.0:
        return [(1.0, 1.0)] * (BARREL_STEPS + 1) * (2 * BARREL_STEPS + 1)
    shift_most, radius = _shift_most(aperture), aperture.stopped_down
    rims = dict.fromkeys((-aperture.rim, aperture.rim))  # a flat rim is the same on both sides
    tables = [
        grid.light_shares_past_barrel(shift_most, radius, rim).ravel().tolist() for rim in rims
    ]
    front, behind = tables[0], tables[-1]
    return list(zip(front, behind, strict=True))


def _shift_most(aperture: Aperture) -> float:
    """Return the shift of each circle of the barrel at a corner, in radii of the opening."""
    return aperture.cat_eye / 2 * aperture.stopped_down


# Points nearer to the center of a disc than this, in pixels, have no direction to the rim.
_CENTRE_PX = 1e-6

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class DiscShape:
    """The image of an aperture in a picture: the disc that a point of light becomes.

    Offsets are in pixels from the center of the disc, x to the right and y down. A radius is half a
    signed circle of confusion: at radius r the point (u, v) of the aperture lights the offset
    (r u, -r v pixel_aspect_ratio), so that in front of the focus the image stands on its head.

    pixel_aspect_ratio   width of a pixel over its height; wide pixels make a disc taller in pixels
    in_picture           middle and corners, for a shape that changes towards the corners
    axial_px             signed diameter in blue minus that in green, and in green minus red
    """

    aperture: Aperture = field(default_factory=Aperture)
    pixel_aspect_ratio: float = 1.0
    in_picture: PictureField = field(default_factory=PictureField)
    axial_px: float = 0.0

    @property
    def is_plain(self) -> bool:
        """Whether discs are ellipses of even brightness."""
        return self.aperture.is_plain and self.axial_px == 0.0

    @property
    def switches(self) -> dict[str, bool]:
        """The defines of lib/aperture.lib.glsl that this disc needs."""
        return {
            "SHAPED": not self.is_plain,
            "COLORED": self.axial_px != 0.0,
            "IMAGED": self.aperture.aperture_image is not None,
        }

    @property
    def half_extents(self) -> Pair:
        """Half the width and height of the box around the disc for each pixel of radius."""
        across, up = self.aperture.half_extents
        return across, up * self.pixel_aspect_ratio

    @property
    def wider_px(self) -> float:
        """The largest difference in disc diameter between green and another color."""
        return abs(self.axial_px)

    @property
    def spreads(self) -> Pair:
        """Standard deviations along x and y, relative to a round disc of the same radius.

        They are the smaller ones of the two sides of the focus, in the middle of the picture.
        """
        x, y = self.half_extents
        spread = min(self.aperture.spreads)
        return x * spread, y * spread

    @property
    def side_variances(self) -> Pair:
        """Variance of a disc in front of the focus and behind it, relative to a round disc."""
        front, behind = self.aperture.spreads
        return front**2, behind**2

    @property
    def diffusion_uniforms(self) -> dict[str, object]:
        """Uniforms of lib/blur_system.lib.glsl for a disc that is not plain."""
        field_uniforms = self.in_picture.diffusion_uniforms(self.aperture, self.pixel_aspect_ratio)
        return field_uniforms | {"side_variances": self.side_variances}

    def light(self, radius_px: float, ramp_px: float, position_px: Pair = (0.0, 0.0)) -> float:
        """Return the sum of `coverage` over all pixels of a large disc, to a close approximation.

        It is exact for a round disc, and for any other as long as the ramp is short beside it.
        """
        across, down = self.half_extents
        shape = math.pi if self.is_plain else self._shape_light(radius_px, position_px)
        # The ramp of an image is a mean over boxes, which keeps the light.
        ramp_light = 0.0 if self.aperture.aperture_image is not None else math.pi * ramp_px**2 / 3
        return radius_px**2 * shape * across * down + ramp_light

    def _shape_light(self, radius_px: float, position_px: Pair) -> float:
        """Return the light of the opening that a disc shows, in square radii, without its edge."""
        rim = math.copysign(1.0, radius_px) * self.aperture.rim
        grid = self.aperture.grid
        if grid is not None:
            return grid.light(self._barrel(position_px), rim)
        return opening.light(self.aperture.diaphragm, self._barrel(position_px), rim)

    def _barrel(self, position_px: Pair) -> Barrel | None:
        """Return the barrel as seen from a position in the picture; None if it cuts nothing."""
        return self.in_picture.barrel(self.aperture, position_px, self.pixel_aspect_ratio)

    def coverage(
        self,
        x: ArrayLike,
        y: ArrayLike,
        radius_px: float,
        ramp_px: float,
        center_px: Pair = (0.0, 0.0),
    ) -> Array:
        """Return the share of light of pixels at the offsets (x, y), 1 wholly inside the disc.

        With a rim that is not flat, 1 is the mean over a round disc. The edge is a ramp of half
        width `ramp_px` all around. The distance to the edge is a first-order estimate: the implicit
        function of the opening over the length of its gradient. `center_px` is the center of the
        disc in the picture; the axial color is not counted.
        """
        if not self.is_plain:
            return self._shaped_coverage(x, y, radius_px, ramp_px, center_px)
        half_width, half_height = self.half_extents
        u, v = np.divide(x, half_width), np.divide(y, half_height)
        from_centre = np.maximum(np.hypot(u, v), _CENTRE_PX)
        gradient = np.hypot(u / half_width, v / half_height) / from_centre
        gradient = np.where(from_centre <= _CENTRE_PX, 1 / min(half_width, half_height), gradient)
        edge_distance = (abs(radius_px) - from_centre) / gradient
        return np.asarray(np.clip((edge_distance + ramp_px) / (2 * ramp_px), 0, 1))

    def _shaped_coverage(
        self, x: ArrayLike, y: ArrayLike, radius_px: float, ramp_px: float, center_px: Pair
    ) -> Array:
        """Return `coverage` of a disc that is not a plain ellipse."""
        half_width, half_height = self.half_extents
        u, v = np.divide(x, half_width * radius_px), -np.divide(y, half_height * radius_px)
        grid, barrel = self.aperture.grid, self._barrel(center_px)
        edges = [] if grid is not None else [opening.past_blades(u, v, self.aperture.diaphragm)]
        if barrel is not None:
            edges.append(opening.past_barrel(u, v, barrel))
        edge_distances = [
            -past / np.maximum(np.hypot(a / half_width, b / half_height), 1e-6)
            for past, a, b in edges
        ]
        edge_distance = np.min(edge_distances, axis=0) if edge_distances else np.inf
        inside = np.clip((edge_distance * abs(radius_px) + ramp_px) / (2 * ramp_px), 0, 1)
        if grid is not None:
            half_sides = (
                ramp_px / (half_width * abs(radius_px)),
                ramp_px / (half_height * abs(radius_px)),
            )
            inside = inside * grid.cover(u, v, half_sides)
        rim = math.copysign(1.0, radius_px) * self.aperture.rim
        return np.asarray(inside * opening.profile(np.minimum(u**2 + v**2, 1.0), rim))

    def scaled(self, scale: float) -> "DiscShape":
        """Return the shape for the picture at another size."""
        return replace(
            self, in_picture=self.in_picture.scaled(scale), axial_px=self.axial_px * scale
        )

    def moved(self, px: Pair) -> "DiscShape":
        """Return the shape for a picture that starts this many pixels farther left and up."""
        return replace(self, in_picture=self.in_picture.moved(px))

    @property
    def uniforms(self) -> dict[str, object]:
        """Uniforms of lib/aperture.lib.glsl; the unit of the shader is the pixel."""
        axes: dict[str, object] = {"aperture_axes": self.half_extents}
        if self.is_plain:
            return axes
        shape = shape_uniforms(self.aperture) | {"aperture_axial_px": self.axial_px}
        return axes | shape | self.in_picture.uniforms(self.aperture, self.pixel_aspect_ratio)

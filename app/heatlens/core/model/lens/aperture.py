"""The shape of the lens opening: the only CPU code that knows it.

Coordinates are in radii of the round lens of the same f-stop: u to the right and v up, seen from
behind the lens. `core/model/lens/pupil.py` gives an opening a size, so that a scene is seen through
it, and `core/model/lens/disc_shape.py` is its image in a picture. Circles and ellipses are simple
enough for these files and shaders/lib/aperture.lib.glsl; all other shapes are in
`core/model/lens/opening.py` and shaders/lib/shaped_aperture.lib.glsl.
tests/render/defocus/test_aperture_on_gpu.py keeps both in agreement. A picture in place of the
diaphragm is in `core/model/lens/opening_image.py`.

A new property of the opening is a field of `OpeningFields`, from which lenses, kits, camera files,
the panel, the command line and Python derive it; a uniform in `shape_uniforms`; and its geometry in
those two files. Passes, renderers and samplers use these values and need no change.
"""

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike, NDArray

from heatlens.core.base.errors import LensError
from heatlens.core.model.lens import opening
from heatlens.core.model.lens.opening import Blades
from heatlens.core.model.lens.opening_fields import BLADES_LEAST, BLADES_MOST, OpeningFields
from heatlens.core.model.lens.opening_image import ImageGrid, OpeningImage
from heatlens.core.model.option import options_of

Array = NDArray[np.float64]
Pair = tuple[float, float]


@dataclass(frozen=True, slots=True, kw_only=True)
class Aperture(OpeningFields):
    """The shape of the opening; round without arguments.

    stopped_down  diameter of the widest opening over that of this one, at least 1

    Raises LensError naming the value and what it may be.
    """

    stopped_down: float = 1.0

    def __post_init__(self) -> None:
        for name, limits in options_of(Aperture).items():
            value = getattr(self, name)
            if limits.least is not None and not limits.allows(value):
                raise LensError(
                    f"The {limits.words} must be between {limits.least:g} and {limits.most:g}, "
                    f"got {value:g}."
                )
        if 0 < self.blades < BLADES_LEAST:
            raise LensError(
                f"The number of blades must be 0, for a round opening, or {BLADES_LEAST} to "
                f"{BLADES_MOST}, got {self.blades}."
            )

    @property
    def is_plain(self) -> bool:
        """Return whether it is a circle or an ellipse, the same for all of the picture."""
        return _is_plain(self)

    @property
    def diaphragm(self) -> Blades:
        """The blades, for the functions of `core/model/lens/opening.py`; none with an image."""
        turn = math.radians(90.0 + self.blade_rotation_deg)
        blades = self.blades if self.aperture_image is None else 0
        return Blades(blades, turn, self.blade_curvature)

    @property
    def grid(self) -> ImageGrid | None:
        """The light of the image, rotated with the lens; None without an image.

        Raises LensError if the file of the image was not read.
        """
        image = self.aperture_image
        return None if image is None else image.grid(self.blade_rotation_deg)

    @property
    def half_extents(self) -> Pair:
        """Half the width and height of the box around the opening, in radii."""
        return 1.0 / self.squeeze, 1.0

    @property
    def area(self) -> float:
        """Area in square radii at the middle of the picture; pi for a round opening."""
        across, up = self.half_extents
        return self.round_area * across * up

    @property
    def round_area(self) -> float:
        """Area in square radii before the squeeze; pi for a round opening."""
        return math.pi if self.diaphragm.number == 0 else _light(self.diaphragm, 0.0)

    @property
    def spreads(self) -> Pair:
        """Standard deviations of discs before and behind the focus, relative to a round disc."""
        if self.is_plain:
            return 1.0, 1.0
        front, behind = (self._variance(rim) for rim in (-self.rim, self.rim))
        return math.sqrt(4 * front), math.sqrt(4 * behind)

    def _variance(self, rim: float) -> float:
        if self.aperture_image is not None:
            return _image_variance(self.aperture_image, rim)
        return _variance(self.diaphragm, rim)

    def light(self, rim: float) -> float:
        """Return the light of a disc with a rim, in square radii before the squeeze."""
        if self.aperture_image is not None:
            return _image_light(self.aperture_image, rim)
        return _light(self.diaphragm, rim)

    def covers(self, u: ArrayLike, v: ArrayLike) -> NDArray[np.bool_]:
        """Return whether light passes at the points (u, v), as an array of their shape.

        This is for the middle of the picture, where the barrel cuts nothing.
        """
        across, up = self.half_extents
        x, y = np.divide(u, across), np.divide(v, up)
        grid = self.grid
        if grid is not None:
            return np.asarray(grid.cover(x, y, (0.0, 0.0)) > 0.0)
        if self.blades == 0:
            return np.asarray(np.hypot(x, y) <= 1.0)
        return np.asarray(opening.past_blades(x, y, self.diaphragm)[0] <= 0.0)

    def points(self, square: Array, radius: float = 1.0) -> Array:
        """Return the points (n, 2) of the opening that belong to `square` (n, 2) in [0, 1)^2.

        Equal areas of the square become equal areas of the opening, so that even points stay even.
        `radius` is that of the lens, in the unit that the points shall have. Neighbours stay
        neighbours, as quasi-random points require: this is the concentric map of Shirley and Chiu
        1997. With an image equal areas become equal light. The caller's weights must account for
        barrel and rim.
        """
        across, up = self.half_extents
        grid = self.grid
        if grid is not None:
            return grid.points(square) * (across * radius, up * radius)
        points = _concentric_disc(square)
        if self.blades:
            points = opening.between_blades(points, self.diaphragm)
        return points * (across * radius, up * radius)


APERTURE_FIELDS = tuple(options_of(Aperture))  # those that a person sets
# Those of them that are of the focus, and leave the opening as it is.
LEAN_FIELDS = tuple(name for name, told in options_of(Aperture).items() if told.term)
LEAN_TERMS = tuple(name for name in LEAN_FIELDS if options_of(Aperture)[name].term == name)


def shape_uniforms(aperture: Aperture) -> dict[str, object]:
    """Return the uniforms of lib/shaped_aperture.lib.glsl that depend on the shape alone."""
    blades, grid = aperture.diaphragm, aperture.grid
    return {
        "aperture_blades": blades.number,
        "aperture_turn": blades.turn,
        "aperture_curvature": blades.curvature,
        "aperture_rim": aperture.rim,
        "aperture_lights": tuple(aperture.light(rim) for rim in (-aperture.rim, aperture.rim)),
        **({} if grid is None else {"aperture_image_scale": grid.scale}),
    }


# Asked some 26 times a frame, by making and checking another opening: Python issued a frame in 1.24
# ms, and issues it in 1.0 since the answer is kept.
@lru_cache(maxsize=64)  # passes ask some dozen times a frame
def _is_plain(aperture: Aperture) -> bool:
    leans = {name: getattr(aperture, name) for name in LEAN_FIELDS}
    return aperture == Aperture(
        squeeze=aperture.squeeze, stopped_down=aperture.stopped_down, **leans
    )


@lru_cache(maxsize=64)
def _light(blades: Blades, rim: float) -> float:
    return opening.light(blades, None, rim)


@lru_cache(maxsize=64)
def _variance(blades: Blades, rim: float) -> float:
    return opening.variance(blades, rim)


# Turning the image changes neither its light nor its variance.


@lru_cache(maxsize=64)
def _image_light(image: OpeningImage, rim: float) -> float:
    return image.grid().light(None, rim)


@lru_cache(maxsize=64)
def _image_variance(image: OpeningImage, rim: float) -> float:
    return image.grid().variance(rim)


def _concentric_disc(square: Array) -> Array:
    """Map [0, 1)^2 to the unit disc so that areas are kept and neighbours stay near."""
    x, y = (2.0 * square - 1.0).T
    is_wide = np.abs(x) > np.abs(y)
    radius = np.where(is_wide, x, y)
    other = np.where(is_wide, y, x)
    share = np.divide(other, radius, out=np.zeros_like(radius), where=radius != 0)
    angle = np.where(is_wide, np.pi / 4 * share, np.pi / 2 - np.pi / 4 * share)
    return np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=-1)

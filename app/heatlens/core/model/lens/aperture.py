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
        for name, option in options_of(Aperture).items():
            value = getattr(self, name)
            if option.least is not None and not option.allows(value):
                raise LensError(
                    f"The {option.words} must be between {option.least:g} and {option.most:g}, "
                    f"got {value:g}."
                )
        if 0 < self.blades < BLADES_LEAST:
            raise LensError(
                f"The number of blades must be 0, for a round opening, or {BLADES_LEAST} to "
                f"{BLADES_MOST}, got {self.blades}."
            )

    @property
    def is_plain(self) -> bool:
        """Whether it is a circle or an ellipse, the same for all of the picture."""
        return _is_plain(self)

    @property
    def diaphragm(self) -> Blades:
        """The blades, for the functions of `core/model/lens/opening.py`; none with an image."""
        turn = math.radians(90.0 + self.blade_rotation_deg)
        blades = self.blades if self.aperture_image is None else 0
        return Blades(number=blades, turn=turn, curvature=self.blade_curvature)

    @property
    def grid(self) -> ImageGrid | None:
        """The light of the image, rotated with the lens; None without an image.

        Raises LensError if the file of the image was not read.
        """
        image = self.aperture_image
        return None if image is None else image.grid(self.blade_rotation_deg)

    @property
    def half_extents(self) -> Pair:
        """Half the width and height of the box around the opening, in radii of the round lens."""
        return 1.0 / self.squeeze, 1.0

    @property
    def area(self) -> float:
        """Area in square radii at the middle of the picture; pi for a round opening."""
        half_width, half_height = self.half_extents
        return self.round_area * half_width * half_height

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
        """Return the variance of a disc with this rim along an axis, in radii^2."""
        if self.aperture_image is not None:
            return _image_variance(self.aperture_image, rim)
        return _variance(self.diaphragm, rim)

    def light(self, rim: float) -> float:
        """Return the light of a disc with this rim, -1 to 1, in square radii before the squeeze."""
        if self.aperture_image is not None:
            return _image_light(self.aperture_image, rim)
        return _light(self.diaphragm, rim)

    def covers(self, u: ArrayLike, v: ArrayLike) -> NDArray[np.bool_]:
        """Return whether light passes at the points (u, v), as an array of their shape.

        This is for the middle of the picture, where the barrel cuts nothing.
        """
        half_width, half_height = self.half_extents
        x, y = np.divide(u, half_width), np.divide(v, half_height)
        grid = self.grid
        if grid is not None:
            return np.asarray(grid.cover(x, y, (0.0, 0.0)) > 0.0)
        if self.blades == 0:
            return np.asarray(np.hypot(x, y) <= 1.0)
        return np.asarray(opening.past_blades(x, y, self.diaphragm)[0] <= 0.0)

    def points(self, square: Array, radius: float = 1.0) -> Array:
        """Return the points (n, 2) of the opening that belong to `square` (n, 2) in [0, 1)^2.

        Equal areas of the square become equal areas of the opening, so that even points stay even.
        `radius` is that of the lens, in the unit that the points shall have. Neighbors stay
        neighbors, as quasi-random points require: this is the concentric map of Shirley and Chiu
        1997. With an image equal areas become equal light. The caller's weights must account for
        barrel and rim.
        """
        half_width, half_height = self.half_extents
        grid = self.grid
        if grid is not None:
            return grid.points(square) * (half_width * radius, half_height * radius)
        points = _concentric_disc(square)
        if self.blades:
            points = opening.map_to_blades(points, self.diaphragm)
        return points * (half_width * radius, half_height * radius)


APERTURE_FIELDS = tuple(options_of(Aperture))  # the fields that a person sets
# Those of them that move the focus and leave the shape of the opening as it is.
FOCUS_OFFSET_FIELDS = tuple(name for name, entry in options_of(Aperture).items() if entry.term)
FOCUS_OFFSET_TERMS = tuple(
    name for name in FOCUS_OFFSET_FIELDS if options_of(Aperture)[name].term == name
)


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


# The answer is cached, because it takes the making and checking of another opening, some 26 times a
# frame. With the cache Python issues a frame in 1.0 ms instead of 1.24 ms.
@lru_cache(maxsize=64)
def _is_plain(aperture: Aperture) -> bool:
    """Return True for an opening that is a circle or an ellipse everywhere in the picture."""
    focus_offsets = {name: getattr(aperture, name) for name in FOCUS_OFFSET_FIELDS}
    return aperture == Aperture(
        squeeze=aperture.squeeze, stopped_down=aperture.stopped_down, **focus_offsets
    )


@lru_cache(maxsize=64)
def _light(blades: Blades, rim: float) -> float:
    return opening.light(blades, barrel=None, rim=rim)


@lru_cache(maxsize=64)
def _variance(blades: Blades, rim: float) -> float:
    return opening.variance(blades, rim)


# The functions below do not need the rotation, which changes neither light nor variance.


@lru_cache(maxsize=64)
def _image_light(image: OpeningImage, rim: float) -> float:
    return image.grid().light(None, rim)


@lru_cache(maxsize=64)
def _image_variance(image: OpeningImage, rim: float) -> float:
    return image.grid().variance(rim)


def _concentric_disc(square: Array) -> Array:
    """Map [0, 1)^2 to the unit disc so that areas are kept and neighbors stay near."""
    x, y = (2.0 * square - 1.0).T
    is_wide = np.abs(x) > np.abs(y)
    radius = np.where(is_wide, x, y)
    shorter = np.where(is_wide, y, x)
    share = np.divide(shorter, radius, out=np.zeros_like(radius), where=radius != 0)
    angle = np.where(is_wide, np.pi / 4 * share, np.pi / 2 - np.pi / 4 * share)
    return np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=-1)

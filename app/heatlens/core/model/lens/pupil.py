"""A lens opening of physical size, through which a scene is seen."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from heatlens.core.model.lens.aperture import Aperture, shape_uniforms
from heatlens.core.model.lens.disc_shape import PictureField

Array = NDArray[np.float64]
Pair = tuple[float, float]


@dataclass(frozen=True, slots=True)
class Pupil:
    """An aperture with a physical size, through which a scene is viewed.

    radius_m         radius of the round lens of the same f-stop in meters; 0 is a pinhole
    axial_dioptres   1 / focus distance of blue minus that of green, and of green minus that of red
    """

    aperture: Aperture
    radius_m: float
    axial_dioptres: float = 0.0

    @property
    def half_extents_m(self) -> Pair:
        """Half the width and height of the opening in meters."""
        half_width, half_height = self.aperture.half_extents
        return half_width * self.radius_m, half_height * self.radius_m

    @property
    def is_plain(self) -> bool:
        """Whether every point of its ellipse lets the same light through."""
        return self.aperture.is_plain

    @property
    def switches(self) -> dict[str, bool]:
        """The defines of lib/aperture.lib.glsl that this pupil needs."""
        is_image = self.aperture.aperture_image is not None
        return {"SHAPED": not self.is_plain, "IMAGED": is_image}

    def points_m(self, square: Array) -> Array:
        """Return points (n, 2) of the opening in meters; see `Aperture.points`."""
        return self.aperture.points(square, self.radius_m)

    def uniforms(self, size: tuple[int, int]) -> dict[str, object]:
        """Return the uniforms of lib/aperture.lib.glsl, whose unit is the meter, for a picture."""
        axes: dict[str, object] = {"aperture_axes": self.half_extents_m}
        if self.is_plain:
            return axes
        return axes | shape_uniforms(self.aperture) | PictureField.of(size).uniforms(self.aperture)


PINHOLE = Pupil(Aperture(), 0.0)

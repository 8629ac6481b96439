"""Position in a picture, for lens effects that vary towards the corners."""

import math
from dataclasses import dataclass, replace
from functools import lru_cache

from heatlens.model.lens.aperture import Aperture
from heatlens.model.lens.opening import FIELD_STEPS, Barrel, variances
from heatlens.model.lens.opening_image import BARREL_STEPS

Pair = tuple[float, float]


@dataclass(frozen=True, slots=True)
class PictureField:
    """The middle and the corners of a picture.

    middle_px         of the picture, from the first pixel's corner, x to the right and y down
    half_diagonal_px  from there to a corner, in pixels across; infinite if the place has no effect
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
        most = _shift_most(aperture)
        per_px = most / self.half_diagonal_px
        image = aperture.aperture_image
        return {
            **({} if image is None else {"aperture_image_passed": _parts_past_barrel(aperture)}),
            "aperture_middle_px": self.middle_px,
            "aperture_shift_per_px": (per_px, -per_px / pixel_aspect_ratio),
            "aperture_shift_most": most,
            "aperture_barrel": aperture.stopped_down if aperture.cat_eye else 0.0,
        }

    def diffusion_uniforms(
        self, aperture: Aperture, pixel_aspect_ratio: float = 1.0
    ) -> dict[str, object]:
        """Return the uniforms for lib/blur_system.lib.glsl, for discs of the same variance."""
        per_px = 1 / self.half_diagonal_px
        return {
            "field_middle_px": self.middle_px,
            "field_per_px": (per_px, per_px / pixel_aspect_ratio),
            "field_variances": field_variances(_shift_most(aperture), aperture.stopped_down),
        }

    def barrel(
        self, aperture: Aperture, place_px: Pair, pixel_aspect_ratio: float = 1.0
    ) -> Barrel | None:
        """Return the barrel as seen from a place; None if it cuts nothing."""
        if aperture.cat_eye == 0.0:
            return None
        most = _shift_most(aperture)
        x = (place_px[0] - self.middle_px[0]) * most / self.half_diagonal_px
        y = (self.middle_px[1] - place_px[1]) * most / self.half_diagonal_px / pixel_aspect_ratio
        part = min(1.0, most / max(math.hypot(x, y), 1e-30))  # constant beyond the corner
        return Barrel((x * part, y * part), aperture.stopped_down)


@lru_cache(maxsize=64)
def field_variances(shift: float, radius: float) -> tuple[Pair, ...]:
    """Return variances along and across the way to the corner, relative to a round disc's.

    The steps are even. `shift` and `radius` are those of the barrel's circles at the corner.
    """
    found = []
    for step in range(FIELD_STEPS):
        along, across = variances(Barrel((shift * step / (FIELD_STEPS - 1), 0.0), radius))
        found.append((4 * along, 4 * across))
    return tuple(found)


@lru_cache(maxsize=64)
def _parts_past_barrel(aperture: Aperture) -> list[Pair]:
    """Return `ImageGrid.parts_past_barrel` for discs in front of the focus and behind it."""
    grid = aperture.grid
    if grid is None or aperture.cat_eye == 0.0:
        return [(1.0, 1.0)] * (BARREL_STEPS + 1) * (2 * BARREL_STEPS + 1)
    most, radius = _shift_most(aperture), aperture.stopped_down
    rims = dict.fromkeys((-aperture.rim, aperture.rim))  # a flat rim is the same on both sides
    sides = [grid.parts_past_barrel(most, radius, rim).ravel().tolist() for rim in rims]
    front, behind = sides[0], sides[-1]
    return list(zip(front, behind, strict=True))


def _shift_most(aperture: Aperture) -> float:
    """Return the shift of each circle of the barrel at a corner, in radii of the opening."""
    return aperture.cat_eye / 2 * aperture.stopped_down

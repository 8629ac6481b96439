"""The size of a lens's discs: that of a real lens, or that of a CG renderer.

A real lens that focuses nearer moves away from the sensor, to the image distance v with
1/v = 1/f - 1/S. Renderers leave the image at the focal length, so that the field of view does not
breathe, and open a disc of radius f/2N in front of that pinhole (Cook, Porter and Carpenter 1984;
Cycles, Mitsuba's `thinlens`, pbrt's `PerspectiveCamera`, Arnold and others). Their discs are
smaller by f/v = 1 - f/S: 5 % for 50 mm at 1 m, 14 % for 85 mm at 0.6 m.
"""

from dataclasses import dataclass
from enum import StrEnum
from typing import assert_never


@dataclass(frozen=True)
class LensModelFacts:
    """The facts of a lens model, from which all other code derives.

    words        its name for people
    meaning      its explanation, for a tooltip or for help
    image_moves  the sensor lies at the image distance, which grows as the focus comes nearer; else
                 it always lies at the focal length
    """

    words: str
    meaning: str
    image_moves: bool


class LensModel(StrEnum):
    """Whether discs are those of a real lens or of a CG renderer, which differ in size."""

    PHOTOGRAPHIC = "photographic"
    RENDERER = "renderer"

    @property
    def facts(self) -> LensModelFacts:
        match self:
            case LensModel.PHOTOGRAPHIC:
                meaning = "discs of a real lens of this f-stop on the film back"
                return LensModelFacts("real lens", meaning, image_moves=True)
            case LensModel.RENDERER:
                meaning = "discs of CG renderers, smaller by (focus - focal length)/focus"
                return LensModelFacts("CG renderer", meaning, image_moves=False)
            case _:
                assert_never(self)

    def focal_over_image_distance(self, focal_length_mm: float, focus_distance_m: float) -> float:
        """Return f/v, 0 to 1: the size of a renderer's discs relative to this model's.

        1 - f/S for a real lens, from the equation of the thin lens, also with focus at infinity; 1
        where the image lies at the focal length.
        """
        if self.facts.image_moves:
            return 1.0 - focal_length_mm / (focus_distance_m * 1e3)
        return 1.0

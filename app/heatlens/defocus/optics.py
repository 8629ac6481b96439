"""What the blur has to know of lens and plate, in pixels."""

import math
from dataclasses import dataclass, field, replace
from enum import IntEnum

import numpy as np
import numpy.typing as npt

from heatlens.model.coc import CocLine
from heatlens.model.disc_shape import DiscShape

_UNCOVERED_MARGIN_PX = 8  # a kernel's tail, and the fill's own neighbourhood


class Color(IntEnum):
    """The colours in the order of their wavelengths, and of their channels."""

    RED = 0
    GREEN = 1
    BLUE = 2


@dataclass(frozen=True, slots=True, eq=False)
class Optics:
    """A lens in front of a plate.

    line          signed coc over dioptres; None: the plate brings its coc itself
    occupied_px   the signed coc there are in the plate, ascending (ends of narrow bins)
    disc          shape of the discs in the pixels of the plate
    plate_shift_px what is to be added to the coc that a plate brings itself
    """

    line: CocLine | None
    occupied_px: npt.NDArray[np.float64]
    disc: DiscShape = field(default_factory=DiscShape)
    plate_shift_px: float = 0.0

    @property
    def nearest_px(self) -> float:
        """The least signed coc in the plate."""
        return float(self.occupied_px[0])

    @property
    def farthest_px(self) -> float:
        """The greatest."""
        return float(self.occupied_px[-1])

    @property
    def at_infinity_px(self) -> float:
        """Coc of what is infinitely far; the farthest there is where no lens tells."""
        return self.farthest_px if self.line is None else self.line.at_infinity_px

    @property
    def uncovered_px(self) -> int:
        """How far behind a silhouette something hidden can still show.

        The nearer blur uncovers half its diameter, and the farther one brings in light from half
        of its own beyond that.
        """
        uncovering = max(-self.nearest_px, 0.0)
        widest = max(uncovering, abs(self.farthest_px))
        reach_px = max(self.disc.half_extents) * (uncovering + widest) / 2
        return math.ceil(reach_px) + _UNCOVERED_MARGIN_PX

    def in_color(self, color: Color) -> "Optics":
        """Return the optics for one colour: green's, or more or less coc by the axial colour."""
        shift_px = (color - Color.GREEN) * self.disc.axial_px
        line = self.line and replace(self.line, at_infinity_px=self.line.at_infinity_px + shift_px)
        aperture = replace(self.disc.aperture, axial_colour_mm=0.0)
        return replace(
            self,
            line=line,
            occupied_px=self.occupied_px + shift_px,
            disc=replace(self.disc, aperture=aperture, axial_px=0.0),
            plate_shift_px=shift_px if line is None else 0.0,
        )

    def scaled(self, proxy: float) -> "Optics":
        """Return the optics for a picture `proxy` times the size."""
        line = self.line and CocLine(
            self.line.at_infinity_px * proxy, self.line.per_dioptre_px * proxy
        )
        disc = self.disc.scaled(proxy)
        return replace(self, line=line, occupied_px=self.occupied_px * proxy, disc=disc)

    def moved(self, px: tuple[float, float]) -> "Optics":
        """Return the optics for a picture whose first pixel lies so many pixels left and up."""
        return replace(self, disc=self.disc.moved(px))

"""Describe the lens and the blur of a plate's depths, in pixels of the plate."""

from dataclasses import dataclass, field, replace
from enum import IntEnum

import numpy as np
import numpy.typing as npt

from heatlens.core.model.focus.coc import NO_LINE, CocLine
from heatlens.core.model.lens.disc_shape import DiscShape


class Color(IntEnum):
    """The colors, in the order of their channels and from long to short wavelengths."""

    RED = 0
    GREEN = 1
    BLUE = 2


@dataclass(frozen=True, slots=True, eq=False)
class Optics:
    """A lens applied to a plate. A signed coc is a diameter in pixels, negative before the focus.

    line           signed coc as a function of dioptres; None if the plate has coc instead of depth
    occupied_px    the signed coc in the plate, ascending (ends of narrow bins)
    until          share of the plate up to each of `occupied_px`, 0..1; empty if not known
    gaps_px        the signed coc at both ends of each gap, ascending (n, 2)
    disc           shape of the discs, in pixels of the plate
    plate_shift_px correction added to the coc that the plate has
    """

    line: CocLine | None
    occupied_px: npt.NDArray[np.float64]
    disc: DiscShape = field(default_factory=DiscShape)
    plate_shift_px: float = 0.0
    gaps_px: npt.NDArray[np.float64] = field(default_factory=lambda: np.zeros((0, 2)))
    until: npt.NDArray[np.float64] = field(default_factory=lambda: np.zeros(0))

    def share_between(self, low_px: float, high_px: float) -> float:
        """Return the share of the plate whose signed coc is between two values, 0..1."""
        if not self.until.size:
            return 0.0
        low, high = np.interp((low_px, high_px), self.occupied_px, self.until)
        return float(high - low)

    @property
    def nearest_px(self) -> float:
        """The smallest signed coc in the plate."""
        return float(self.occupied_px[0])

    @property
    def farthest_px(self) -> float:
        """The largest signed coc in the plate."""
        return float(self.occupied_px[-1])

    @property
    def at_infinity_px(self) -> float:
        """The coc at infinity; for a plate with its own coc, its largest one."""
        return self.farthest_px if self.line is None else self.line.at_infinity_px

    @property
    def infinity_uniforms(self) -> dict[str, object]:
        """The uniforms of lib/silhouette.lib.glsl."""
        return (self.line or NO_LINE).focus_offset_uniforms | {
            "at_infinity_px": self.at_infinity_px
        }

    def in_color(self, color: Color) -> "Optics":
        """Return the optics for one color, whose focus differs because of axial color.

        Green keeps the focus of the lens.
        """
        shift_px = (color - Color.GREEN) * self.disc.axial_px
        line = self.line and replace(self.line, at_infinity_px=self.line.at_infinity_px + shift_px)
        aperture = replace(self.disc.aperture, axial_colour_mm=0.0)
        return replace(
            self,
            line=line,
            occupied_px=self.occupied_px + shift_px,
            gaps_px=self.gaps_px + shift_px,
            disc=replace(self.disc, aperture=aperture, axial_px=0.0),
            plate_shift_px=shift_px if line is None else 0.0,
        )

    def scaled(self, proxy: float) -> "Optics":
        """Return the optics for a picture scaled by `proxy`."""
        return replace(
            self,
            line=self.line and self.line.scaled(proxy),
            occupied_px=self.occupied_px * proxy,
            gaps_px=self.gaps_px * proxy,
            disc=self.disc.scaled(proxy),
        )

    def moved(self, px: tuple[float, float]) -> "Optics":
        """Return the optics for a picture that begins this many pixels farther left and up."""
        line = self.line and replace(self.line, focus_offset=self.line.focus_offset.moved(px))
        return replace(self, line=line, disc=self.disc.moved(px))

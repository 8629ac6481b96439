"""What the blur has to know of lens and plate, in pixels."""

from dataclasses import dataclass, replace

from heatlens.model.coc import CocLine


@dataclass(frozen=True, slots=True)
class Optics:
    """A lens in front of a plate.

    line                     signed coc over dioptres; None: the plate brings its coc itself
    nearest_px, farthest_px  the least and the greatest signed coc in the plate
    axis_scales              (x, y) diameter along the axis over coc: squeeze and pixel aspect
    """

    line: CocLine | None
    nearest_px: float
    farthest_px: float
    axis_scales: tuple[float, float] = (1.0, 1.0)

    @property
    def at_infinity_px(self) -> float:
        """Coc of what is infinitely far; the farthest there is where no lens tells."""
        return self.farthest_px if self.line is None else self.line.at_infinity_px

    def scaled(self, proxy: float) -> "Optics":
        """The same on a picture `proxy` times the size."""
        line = self.line and CocLine(
            self.line.at_infinity_px * proxy, self.line.per_dioptre_px * proxy
        )
        return replace(
            self,
            line=line,
            nearest_px=self.nearest_px * proxy,
            farthest_px=self.farthest_px * proxy,
        )

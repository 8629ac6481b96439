"""Focus peaking: areas in focus are coloured, as on camera monitors."""

from dataclasses import dataclass
from enum import StrEnum

from heatlens.base.errors import InputError
from heatlens.model.option import check_range

Rgb = tuple[float, float, float]

# Display values by name; the first is a colour that is rare in scenes.
PEAKING_COLORS: dict[str, Rgb] = {
    "magenta": (1.0, 0.2, 0.75),
    "red": (1.0, 0.15, 0.1),
    "yellow": (1.0, 0.9, 0.1),
    "green": (0.2, 1.0, 0.3),
    "blue": (0.2, 0.55, 1.0),
    "white": (1.0, 1.0, 1.0),
}


STOPS_RANGE = 0.05, 3.0  # contrast of an edge, in stops
BLUR_RANGE = 0.1, 4.0  # unit: acceptable circles of confusion


class PeakingOn(StrEnum):
    """Where focus peaking draws its colour."""

    PICTURE = "edges of the picture"  # seen through the lens, and the silhouettes
    DEPTH = "all at the distance"  # with or without edges


@dataclass(frozen=True, slots=True)
class Peaking:
    """How peaking is drawn.

    on     edges alone, or everything in focus
    stops  contrast of an edge that is coloured, in stops of its light
    blur   how large a blur still counts as in focus, in acceptable circles of confusion
    color  name of the colour

    Raises InputError for numbers out of range and for unknown colours.
    """

    on: PeakingOn = PeakingOn.PICTURE
    stops: float = 0.5
    blur: float = 1.0
    color: str = next(iter(PEAKING_COLORS))

    def __post_init__(self) -> None:
        """Check the numbers and the name of the colour."""
        check_range("stops", self.stops, *STOPS_RANGE)
        check_range("blur", self.blur, *BLUR_RANGE)
        if self.color not in PEAKING_COLORS:
            known = ", ".join(PEAKING_COLORS)
            raise InputError(f"{self.color!r} is not a peaking colour; known are {known}.")

    @property
    def rgb(self) -> Rgb:
        """Its colour as display values."""
        return PEAKING_COLORS[self.color]


USUAL_PEAKING = Peaking()

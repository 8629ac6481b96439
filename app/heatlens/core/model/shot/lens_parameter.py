"""The parameters of a lens that can have keys, and the facts of each that the program shows.

`--key`, the key dots of the Lens panel, the rows and the curves of the timeline, and tables of keys
take them from the member. A new member also needs its curve in `LensCurves`.
"""

from dataclasses import dataclass
from enum import StrEnum
from math import inf

from heatlens.core.model.curves.interpolation import Scale
from heatlens.core.model.lens.lens import THIRD_STOPS, Lens
from heatlens.core.model.option import Option, options_of
from heatlens.core.model.units import format_distance

_DISTANCES_M = (
    *(0.1, 0.15, 0.2, 0.3, 0.4, 0.5, 0.6, 0.8, 1, 1.2, 1.5, 2, 2.5, 3, 4, 5, 7, 10, 20, 50),
    inf,
)
_FINE_M = tuple(round(x * 10.0**power / 20, 4) for power in (-1, 0, 1) for x in range(20, 200))
_FOCAL_LENGTHS_MM = (
    *(4, 6, 8, 10, 12, 14, 16, 18, 21, 24, 28, 32, 35, 40, 50, 65, 75, 85, 100, 135, 150, 180),
    *(200, 250, 300, 400, 500, 600, 800, 1200),
)
_SQUEEZES = (1, 1.1, 1.2, 1.25, 1.3, 1.33, 1.4, 1.5, 1.6, 1.7, 1.8, 1.9, 2)
_STEPS = tuple(range(-20, 21))
_FINE_STEPS = tuple(x / 10 for x in range(-200, 201))


@dataclass(frozen=True, slots=True, kw_only=True)
class ParameterFacts:
    """How a parameter is drawn, labeled and typed.

    scales        those on which its keys can lie; its curve is drawn on the first
    labels        lists of values to label beside its curve, from few to many
    fine          values to label instead where hardly any of them are visible
    span_least    the smallest visible range of its curve, in positions of the drawing
    factor        positions of the drawing for each unit of the scale; positions grow downwards
    sign          a format of a number with its unit; the focus is formatted as a distance instead
    typed         its name in `--key`, if not that of its option
    control       its control in the Lens panel, if not named by its label
    unseen_share  the share by which a recorded value may differ without being seen
    """

    scales: tuple[Scale, ...]
    labels: tuple[tuple[float, ...], ...]
    fine: tuple[float, ...] = ()
    span_least: float
    factor: float = -1.0
    sign: str = "{}"
    typed: str = ""
    control: str = ""
    unseen_share: float = 0.002


class LensParameter(StrEnum):
    """The fields of Lens that can have keys."""

    FOCUS_DISTANCE = "focus_distance_m"
    F_STOP = "f_stop"
    FOCAL_LENGTH = "focal_length_mm"
    SQUEEZE = "squeeze"
    TILT = "tilt_deg"
    SPLIT = "split_dioptres"

    @property
    def facts(self) -> ParameterFacts:
        return _FACTS[self]

    @property
    def words(self) -> str:
        """The name as people say it."""
        return self._option.words

    @property
    def typed(self) -> str:
        """The name in `--key`."""
        return self.facts.typed or self._option.flag

    @property
    def attribute(self) -> str:
        """The name of its option among parsed arguments."""
        return self._option.flag.replace("-", "_")

    @property
    def control(self) -> str:
        """The name under which the Lens panel reports its control."""
        return self.facts.control or self._option.label

    def format_value(self, value: float, unit: str, digits: str = "g") -> str:
        """Format a value with its unit; `unit` is that of distances."""
        if self is LensParameter.FOCUS_DISTANCE:
            return format_distance(value, unit)
        return self.facts.sign.format(f"{value:{digits}}")

    @property
    def _option(self) -> Option:
        return options_of(Lens)[self]


# Scales of the focus between keys, by their words in files and on the command line.
FOCUS_SCALES = {"dioptres": Scale.RECIPROCAL, "distance": Scale.LINEAR}

_FACTS = {
    LensParameter.FOCUS_DISTANCE: ParameterFacts(
        scales=tuple(FOCUS_SCALES.values()),
        labels=(_DISTANCES_M,),
        fine=_FINE_M,
        span_least=0.04,
        factor=1.0,
        typed="focus",
        control="distance",
    ),
    LensParameter.F_STOP: ParameterFacts(
        scales=(Scale.LOGARITHMIC,),
        labels=(THIRD_STOPS[::3], THIRD_STOPS),
        span_least=2.0,
        factor=-2.0,  # one stop doubles the light, which goes with the square of the f-number
        sign="f/{}",
        unseen_share=0.01,
    ),
    LensParameter.FOCAL_LENGTH: ParameterFacts(
        scales=(Scale.LOGARITHMIC,), labels=(_FOCAL_LENGTHS_MM,), span_least=1.0, sign="{} mm"
    ),
    LensParameter.SQUEEZE: ParameterFacts(
        scales=(Scale.LINEAR,), labels=(_SQUEEZES,), span_least=0.2, sign="{} x"
    ),
    LensParameter.TILT: ParameterFacts(
        scales=(Scale.LINEAR,),
        labels=(_STEPS,),
        fine=_FINE_STEPS,
        span_least=2.0,
        sign="{}°",
    ),
    LensParameter.SPLIT: ParameterFacts(
        scales=(Scale.LINEAR,),
        labels=(_STEPS,),
        fine=_FINE_STEPS,
        span_least=0.2,
        sign="{} D",
    ),
}

"""How the blur is computed: never how much of it there is."""

from dataclasses import dataclass
from enum import StrEnum

from heatlens.errors import InputError


class Bokeh(StrEnum):
    """The shape a point of light takes."""

    HEAT = "heat"  # one implicit step: Kass, Lefohn, Owens 2006
    GAUSSIAN = "gaussian"  # several steps, round
    DISC = "disc"  # complex poles: a lens


class Quality(StrEnum):
    """How closely the shape is met; the amount of blur is the same at each."""

    DRAFT = "draft"
    PREVIEW = "preview"
    FILM = "film"


LAYERS_MAX = 7
PROXY_MIN = 1 / 16


@dataclass(frozen=True, slots=True)
class DefocusSettings:
    """Options of the blur.

    layers  how many depth layers the picture is cut into, 1 (no uncovering) to LAYERS_MAX; None:
            what the quality brings
    proxy   scale of the picture that is worked on, PROXY_MIN to 1; blur scales with it
    """

    bokeh: Bokeh = Bokeh.DISC
    quality: Quality = Quality.FILM
    layers: int | None = None
    proxy: float = 1.0

    def __post_init__(self) -> None:
        if self.layers is not None and not 1 <= self.layers <= LAYERS_MAX:
            raise InputError(f"layers must be 1 to {LAYERS_MAX}, got {self.layers}")
        if not PROXY_MIN <= self.proxy <= 1.0:
            raise InputError(f"proxy must be {PROXY_MIN:g} to 1, got {self.proxy:g}")

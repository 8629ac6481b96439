"""How the blur is computed, never how much blur there is."""

from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum
from functools import cache
from typing import assert_never

from heatlens.core.base.errors import InputError
from heatlens.core.model.option import option_field, options_of


class Bokeh(StrEnum):
    """The shape a point of light takes."""

    HEAT = "heat"  # one implicit step: Kass, Lefohn, Owens 2006
    GAUSSIAN = "gaussian"  # several steps give a round shape
    DISC = "disc"  # complex poles: a lens


class Quality(StrEnum):
    """How closely the shape of the disc is matched; the amount of blur is always the same."""

    DRAFT = "draft"
    PREVIEW = "preview"
    FILM = "film"
    FINAL = "final"


@dataclass(frozen=True)
class MethodFacts:
    """The facts of a method, from which all other code derives.

    meaning         words that explain it
    needs_scene     it draws a 3D scene from many points of the lens, which a plate does not allow
    grows_with_blur  its work depends on how large the blur is
    views_are       what `views` counts; "" if the method has no views
    """

    meaning: str
    needs_scene: bool = False
    grows_with_blur: bool = False
    views_are: str = ""


class Method(StrEnum):
    """How the light of a pixel is spread over its disc, for the same lens and plate."""

    DIFFUSION = "diffusion"
    HEAT = "heat"  # Kass, Lefohn, Owens 2006
    GATHER = "gather"  # Riguer et al. 2003
    SCATTER = "scatter"  # Potmesil and Chakravarty 1981
    PYRAMID = "pyramid"  # Williams 1983, Burt and Adelson 1983
    ACCUMULATION = "accumulation"  # Haeberli and Akeley 1990
    RAYTRACED = "raytraced"  # Cook, Porter, Carpenter 1984

    @property
    def facts(self) -> MethodFacts:
        """What the method does and needs, for help texts and refusals."""
        match self:
            case Method.DIFFUSION:
                return MethodFacts("layered diffusion (see --bokeh, --quality, --layers)")
            case Method.HEAT:
                return MethodFacts("one layer of heat, the basic form of diffusion")
            case Method.GATHER:
                return MethodFacts("each pixel averages its disc", grows_with_blur=True)
            case Method.SCATTER:
                return MethodFacts("each pixel is drawn as its disc", grows_with_blur=True)
            case Method.PYRAMID:
                return MethodFacts("blurred copies at smaller sizes")
            case Method.ACCUMULATION:
                words = "a 3D scene, seen from many points of the lens"
                return MethodFacts(words, needs_scene=True, views_are="views")
            case Method.RAYTRACED:
                words = "rays through the lens into a scene"
                return MethodFacts(words, needs_scene=True, views_are="rays a pixel")
            case _:
                assert_never(self)

    @property
    def needs_scene(self) -> bool:
        """Whether the method draws a 3D scene; a plate cannot be seen from elsewhere."""
        return self.facts.needs_scene


LAYERS_MAX = 7
VIEWS_MAX = 65536
PARTS = (1, 7, 19, 37)  # rings around a middle
# Counts the changes of the blur that changed pictures; an export renders frames of others anew.
BLUR_EDITION = 18
PROXY_MIN = 1 / 16
_ONLY_DIFFUSION = {
    "asked_by": lambda method: method is Method.DIFFUSION,
    "why_not": "has no such choice; only diffusion does",
}


@dataclass(frozen=True, slots=True)
class DefocusSettings:
    """Options of the blur.

    layers  number of depth layers, 1 (no uncovering) to LAYERS_MAX; None: set by the quality
    proxy   scale of the working picture, PROXY_MIN to 1; blur scales with it
    quality  None: film, and final in an export of plates
    method  only diffusion uses bokeh, quality, layers and parts
    views   lens points of accumulation, or rays of each pixel
    parts   parts of the lens, where surfaces of different blur overlap

    Raises InputError for a number outside its range.
    """

    bokeh: Bokeh = option_field(
        Bokeh.DISC,
        "bokeh",
        "shape of a point of light: disc, as in a lens (default), gaussian, or heat, a "
        "four-pointed star and the fastest",
        **_ONLY_DIFFUSION,
    )
    quality: Quality | None = option_field(
        None,
        "quality",
        "how closely that shape is matched; the amount of blur is the same (default: film, and "
        "final for an export of plates); final is film in parts of the lens, see --parts",
        **_ONLY_DIFFUSION,
    )
    layers: int | None = option_field(
        None,
        "layers",
        f"depth layers, 1 (nothing is uncovered) to {LAYERS_MAX} (default: set by the quality)",
        metavar="N",
        least=1,
        most=LAYERS_MAX,
        **_ONLY_DIFFUSION,
    )
    proxy: float = option_field(
        1.0,
        "proxy",
        f"work on a smaller picture, {PROXY_MIN:g} to 1 of its resolution; blur scales with it",
        metavar="SCALE",
        least=PROXY_MIN,
        most=1,
    )
    method: Method = option_field(
        Method.DIFFUSION,
        "method",
        "diffusion (default); for comparison, without --bokeh, --quality and --layers: heat, "
        "gather, scatter and pyramid; for scenes accumulation and raytraced, the truth from "
        "--views points of the lens",
    )
    views: int = option_field(
        66,
        "views",
        f"points of the lens, or rays of each pixel, 1 to {VIEWS_MAX} (default 66)",
        metavar="N",
        least=1,
        most=VIEWS_MAX,
        asked_by=lambda method: method.needs_scene,
        why_not="sees the scene from one point only",
    )
    parts: int = option_field(
        1,
        "parts",
        "1, 7, 19 or 37 parts of the lens: more is truer where blurred things overlap, and slower "
        "(default: 1; for the quality final 19, or 7 if hidden surfaces are guessed)",
        metavar="N",
        least=PARTS[0],
        most=PARTS[-1],
        **_ONLY_DIFFUSION,
    )

    def __post_init__(self) -> None:
        for name, option in options_of(DefocusSettings).items():
            value = getattr(self, name)
            if isinstance(value, int | float) and not option.allows(value):
                words = option.words.capitalize()
                raise InputError(
                    f"{words} must be {option.least:g} to {option.most:g}, got {value:g}."
                )
        if self.parts not in PARTS:
            raise InputError(f"Parts of the lens must be 1, 7, 19 or 37, got {self.parts}.")

    @property
    def effective_quality(self) -> Quality:
        """The quality of the picture: film if none is named."""
        return self.quality or Quality.FILM


@cache  # each frame of the window asks for every method
def barred_methods(has_many_views: bool) -> Mapping[str, str]:
    """Return the methods that are unavailable for the open source, with the reason."""
    reason = "This needs a 3D scene, seen from many points of the lens; a plate is seen from one."
    return (
        {} if has_many_views else {str(method): reason for method in Method if method.needs_scene}
    )

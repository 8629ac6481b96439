"""The overlays: what is drawn over the picture, or in its place, each declared in one record.

Panel, menus, keys, palette, legend, the shader's choice and the pages of browsers derive from
`OVERLAYS`, so that a new overlay is one more record, and the function of the shader that it names.
"""

import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from itertools import pairwise

from heatlens.core.base.errors import InputError
from heatlens.core.model.units import format_distance
from heatlens.core.model.view.guides import Peaking, PeakingOn, Rgb


@dataclass(frozen=True)
class Entry:
    """A color of a legend and its meaning."""

    color: Rgb
    words: str


@dataclass(frozen=True)
class LegendFacts:
    """The numbers of a legend; diameters are in pixels of the whole picture.

    nearest_px, farthest_px  the signed diameters of what is nearest and what is farthest
    sharp_px         the largest diameter that counts as sharp
    layer_limits_px  the signed diameters between the layers, near to far
    near_m, far_m    distances of the ends of the plate; None where it has no distances
    unit             unit of distances, "m" or "ft"
    """

    nearest_px: float
    farthest_px: float
    sharp_px: float
    layer_limits_px: tuple[float, ...]
    near_m: float | None
    far_m: float | None
    unit: str

    @property
    def in_focus(self) -> str:
        """Words for what counts as sharp."""
        return f"in focus, up to {self.sharp_px:.1f} px"


@dataclass(frozen=True, eq=False)
class Overlay:
    """One overlay: everything that differs between overlays.

    name      its name in the state of a view and in the palette
    words     the name of its command, which menus, keys, palette and pages show
    label     the words on its button in the Display panel
    key       the shortcut of its command; "" for none
    function  the function of `overlay.comp.glsl` that colors a pixel
    colors    its colors, display RGB, by the names that the shader knows them by
    legend    returns the words beside each color, in the same order; "" leaves a color out
    """

    name: str
    words: str
    label: str
    key: str
    function: str
    colors: Mapping[str, Rgb | list[Rgb]]
    legend: Callable[[LegendFacts], Iterable[str]]

    def tints(self) -> Iterator[Rgb]:
        """Yield its colors one by one, as the legend shows them."""
        for color in self.colors.values():
            yield from color if isinstance(color, list) else [color]


def _coc_words(facts: LegendFacts) -> Iterable[str]:
    """Yield the diameters of the nearest, sharp and farthest surfaces; "" for those in focus."""
    yield f"nearest {-facts.nearest_px:.1f} px" if facts.nearest_px < -facts.sharp_px else ""
    yield facts.in_focus
    yield f"farthest {facts.farthest_px:.1f} px" if facts.farthest_px > facts.sharp_px else ""


def _depth_words(facts: LegendFacts) -> Iterable[str]:
    """Yield the distances of the near and the far end, or words where they are unknown."""
    for distance_m, end_word in ((facts.near_m, "nearest"), (facts.far_m, "farthest")):
        if distance_m is None:
            yield end_word
        else:
            is_far = math.isinf(distance_m)
            yield "infinity" if is_far else format_distance(distance_m, facts.unit)


def _layer_words(facts: LegendFacts) -> Iterable[str]:
    """Return the range of each layer's signed CoC in pixels, near to far."""
    ends = [f"{limit:+.0f}" for limit in facts.layer_limits_px]
    if not ends:
        return ["one layer"]
    between = (f"{a} to {b} px" for a, b in pairwise(ends))
    return [f"up to {ends[0]} px", *between, f"from {ends[-1]} px"]


NO_OVERLAY = Overlay(
    name="none",
    words="",
    label="off",
    key="",
    function="no_color",
    colors={},
    legend=lambda _facts: (),
)
# Each begins with its name, words, label, key and function.
OVERLAYS = (
    Overlay(
        *("zones", "Near, in focus, far", "zones", "Z", "zones_color"),
        # Vermilion, yellow and blue differ in brightness too, for those who cannot tell red from
        # green. Source: M. Okabe, K. Ito, Color Universal Design.
        {
            "OVERLAY_NEAR": (0.84, 0.37, 0.0),
            "OVERLAY_FOCUS": (0.94, 0.89, 0.26),
            "OVERLAY_FAR": (0.0, 0.447, 0.698),
        },
        lambda facts: ("in front", facts.in_focus, "behind"),
    ),
    Overlay(
        *("focus plane", "Plane in focus", "plane", "P", "focus_plane_color"),
        {"OVERLAY_FOCUS_LINE": (1.0, 0.86, 0.35)},
        lambda _facts: ("cut by the plane in focus",),
    ),
    Overlay(
        *("coc", "Circle of confusion", "blur", "C", "coc_color"),
        {
            "OVERLAY_COC_NEAR": (1.0, 0.55, 0.12),
            "OVERLAY_COC_SHARP": (0.10, 0.30, 0.14),
            "OVERLAY_COC_FAR": (0.2, 0.6, 1.0),
        },
        _coc_words,
    ),
    Overlay(
        *("depth", "Depth", "depth", "V", "depth_color"),
        {"OVERLAY_DEPTH_NEAR": (1.0, 1.0, 1.0), "OVERLAY_DEPTH_FAR": (0.0, 0.0, 0.0)},
        _depth_words,
    ),
    Overlay(
        *("layers", "Layers", "layers", "L", "layers_color"),
        {
            "OVERLAY_LAYERS": [
                *((0.90, 0.20, 0.55), (0.95, 0.35, 0.15), (0.97, 0.65, 0.10), (0.90, 0.90, 0.20)),
                *((0.35, 0.85, 0.30), (0.15, 0.75, 0.80), (0.25, 0.45, 0.95), (0.60, 0.35, 0.95)),
            ]
        },
        _layer_words,
    ),
)


def overlays_by_name() -> dict[str, Overlay]:
    """Return all that a view can show, no overlay first."""
    return {overlay.name: overlay for overlay in (NO_OVERLAY, *OVERLAYS)}


def overlay_of(name: str) -> Overlay:
    """Return the overlay of this name. Raises InputError if there is none."""
    overlays = overlays_by_name()
    if name not in overlays:
        raise InputError(f"There is no overlay {name!r}; there are {', '.join(overlays)}.")
    return overlays[name]


def legend_entries(name: str, facts: LegendFacts, peaking: Peaking | None = None) -> list[Entry]:
    """Return the legend of an overlay, and of focus peaking if that is on."""
    overlay = overlay_of(name)
    rows = zip(overlay.tints(), overlay.legend(facts), strict=False)
    legend = [Entry(tint, words) for tint, words in rows if words]
    if peaking is not None:
        words_of_peaking = (
            "edges in focus" if peaking.on is PeakingOn.PICTURE else "peaking, in focus"
        )
        limit_px = peaking.blur * facts.sharp_px
        legend.append(Entry(peaking.rgb, f"{words_of_peaking}, up to {limit_px:.1f} px"))
    return legend

"""Draw charts of the methods with matplotlib, with axes, colors and legends in one style."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, TypedDict

from heatlens.core.base.extras import import_extra
from heatlens.media.files.atomic_file import replace_atomically

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.axis import Axis
    from matplotlib.figure import Figure

# Colors that people with color blindness can tell apart (Okabe and Ito 2008), darkened for
# white paper; each method has a marker of its own as well.
_STYLES = {
    "diffusion": ("#D55E00", "o"),
    "heat": ("#B8860B", "s"),
    "gather": ("#0072B2", "^"),
    "scatter": ("#3A9BD0", "v"),
    "pyramid": ("#007A59", "D"),
    "accumulation": ("#B0528A", "P"),
    "raytraced": ("#555555", "X"),
}
_OTHER_STYLE = ("#000000", "o")
GREY = "#666666"
_DPI = 150
_FIXED_TEXT = {"svg.fonttype": "none", "svg.hashsalt": "heatlens"}  # the same file every time


@dataclass(frozen=True, slots=True)
class Entry:
    """One line of a legend: the artist that it explains, its text and its position.

    height  entries are sorted by decreasing height
    """

    artist: "Artist"
    text: str
    height: float


def new_figure(width_in: float, height_in: float) -> "Figure":
    """Return an empty figure with automatic layout of titles and legends.

    Raises InputError with what to install if matplotlib is missing.
    """
    figure: Figure = import_extra("matplotlib.figure").Figure(
        figsize=(width_in, height_in), layout="constrained"
    )
    return figure


def write_figure(path: Path, figure: "Figure") -> None:
    """Write a figure as PNG or SVG, by its suffix, completely or not at all.

    Raises InputError if the file cannot be written.
    """
    matplotlib = import_extra("matplotlib")
    kind = path.suffix.lower()[1:]
    metadata = {"Date": None} if kind == "svg" else None
    with replace_atomically(path) as temporary_path, matplotlib.rc_context(_FIXED_TEXT):
        figure.savefig(temporary_path, format=kind, dpi=_DPI, metadata=metadata)


class Style(TypedDict):
    """Color and marker of a line, as keywords of matplotlib."""

    color: str
    marker: str


def style_of(method: str) -> Style:
    """Return color and marker of a method; text after its name, as in "heat 23", is ignored."""
    color, marker = _STYLES.get(method.partition(" ")[0], _OTHER_STYLE)
    return {"color": color, "marker": marker}


def plain_axes(axes: "Axes", title: str = "") -> None:
    """Set a faint grid, no frame at the top and the right, and a title at the left."""
    axes.grid(alpha=0.3)
    axes.spines[["top", "right"]].set_visible(False)
    axes.set_title(title, loc="left", fontsize="medium")


def plain_ticks(axis: "Axis") -> None:
    """Label a logarithmic axis with 1, 2, 5, 10 instead of powers; a long one with decades."""
    low, high = axis.get_view_interval()
    steps = (1, 2, 5) if high / low < 1000 else (1,)
    powers = range(math.floor(math.log10(low)), math.ceil(math.log10(high)) + 1)
    ticks = [step * 10.0**power for power in powers for step in steps]
    visible_ticks = [tick for tick in ticks if low <= tick <= high]
    axis.set_ticks(visible_ticks, [f"{tick:g}" for tick in visible_ticks])
    axis.set_ticks([], minor=True)


def legend_beside(axes: "Axes", entries: Sequence[Entry]) -> None:
    """Place a legend right of the axes, with the entries in the vertical order of their lines."""
    ordered = sorted(entries, key=lambda entry: -entry.height)
    axes.legend(
        [entry.artist for entry in ordered],
        [entry.text for entry in ordered],
        loc="center left",
        bbox_to_anchor=(1.0, 0.5),
        frameon=False,
        fontsize="small",
    )

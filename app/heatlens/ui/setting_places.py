"""List the labels of each panel, so that the palette can find a setting and show its panel.

A test draws the panels and checks that the labels here are those that are drawn.
"""

from functools import partial

from heatlens.export.options import ExportOptions
from heatlens.model.aperture import Aperture
from heatlens.model.option import options_of
from heatlens.session.facts import Facts
from heatlens.session.time.timeline import Timeline
from heatlens.ui.actions import Action
from heatlens.ui.seek import seek
from heatlens.ui.state import UiState

SETTINGS: dict[str, tuple[str, ...]] = {
    "Lens": (
        *(told.label for told in options_of(Aperture).values()),
        *("distance", "f-stop", "T-stop", "focal length", "film back", "sensor width"),
        *("sharp up to", "lens model", "distances from", "pupil offset", "kit", "lens"),
        *("the view breathes", "at f-stop", "method", "bokeh", "quality", "layers"),
        *("parts", "picture size", "views", "rays a pixel", "source", "the lens follows it"),
    ),
    "Display": (
        *(
            "display",
            "view",
            "input",
            "exposure",
            "gamma",
            "overlay",
            "compare",
            "gain",
            "compare with",
        ),
    ),
    "Plate": (
        *("channel", "convention", "near", "far", "kind", "scene unit", "in metres"),
        *("colour layer", "take out bright grains", "neighbours"),
    ),
    "Scene": ("camera", "clip", "size", "up axis", "unit"),
    "Export": (
        *(told.label for told in options_of(ExportOptions).values() if told.label),
        *("folder", "name", "as", "at quality", "for", "guides and desqueeze of the window"),
    ),
    "Marks": ("close focus",),
    "Guides": (
        *("matte", "own aspect", "opacity", "safe areas", "thirds", "centre cross", "desqueeze"),
        *("own desqueeze", "colour what is in focus", "colours", "in", "contrast", "blur up to"),
    ),
    "Speed": ("time each pass",),
    "Timeline": (
        *("frame", "timecode", "frames per second", "ending", "pace", "missing frames"),
        *("auto key", "curve", "interpolation"),
    ),
}


def setting_places(facts: Facts, timeline: Timeline, ui: UiState) -> tuple[Action, ...]:
    """Return an action for each setting, which shows the setting in its panel."""
    return tuple(
        Action(
            words,
            f"{panel} tab",
            partial(_show, ui, panel, words),
            barred=partial(_why_not, facts, timeline, panel),
        )
        for panel, settings in SETTINGS.items()
        for words in settings
    )


def _why_not(facts: Facts, timeline: Timeline, panel: str) -> str:
    if panel == "Scene" and not facts.has_camera:
        return "Only a scene has these settings, and none is open."
    if panel == "Timeline" and not timeline.has_time:
        return "Only what has several frames has a timeline."
    return ""


def _show(ui: UiState, panel: str, words: str) -> None:
    ui.panels[panel] = True
    seek(panel, words)

"""Offer the settings of the panels as commands, so that the palette finds them.

The palette shows a setting in its panel by its label, or chooses one of its values. A test draws
the panels and checks that the labels here are those that are drawn.
"""

from collections.abc import Callable
from dataclasses import replace
from functools import partial

from heatlens.core.model.focus.live_focus import Follow
from heatlens.core.model.lens.aperture import Aperture
from heatlens.core.model.lens.filmback import FILMBACKS
from heatlens.core.model.option import Values, options_of
from heatlens.core.model.shot.settings import Bokeh, Method, Quality, barred_methods
from heatlens.core.model.view.guides import PEAKING_COLORS, SQUEEZES, PeakingOn
from heatlens.core.model.view.overlays import overlays_by_name
from heatlens.deliver.export.options import ExportOptions
from heatlens.studio.board.board import Board, Changeable
from heatlens.studio.board.command import Command
from heatlens.studio.board.controls import TimeControl
from heatlens.studio.settings.preferences import Theme
from heatlens.studio.ui.seek import show_setting
from heatlens.studio.ui.state import UiState

_MENU = "Setting"
_SCENE_SETTINGS = ("camera", "clip", "size", "up axis", "unit")
SETTINGS: dict[str, tuple[str, ...]] = {
    "Lens": (
        *(option.label for option in options_of(Aperture).values()),
        *("distance", "f-stop", "T-stop", "focal length", "lens change", "film back"),
        *("sensor width", "sharp up to", "lens model", "distances from", "pupil offset", "kit"),
        *("lens", "the view breathes", "at f-stop", "flat depth", "never blur", "only blur"),
        *("method", "bokeh", "quality", "layers", "parts", "picture size", "views"),
        *("rays a pixel", "time each pass", "source", "the lens follows it"),
    ),
    "Marks": ("close focus", *(option.label for option in options_of(Follow).values())),
    "Display": (
        *("channel", "exposure", "gamma", "display", "view", "input", "overlay", "compare", "gain"),
        *("compare with", "focus peaking", "show", "colour", "contrast", "up to"),
        *("frame mask", "own aspect", "opacity", "safe areas", "thirds", "centre cross"),
        *("desqueeze", "own desqueeze"),
    ),
    "Export": (
        *(option.label for option in options_of(ExportOptions).values() if option.label),
        *("folder", "name", "where", "processes", "format", "quality", "for"),
        "guides and desqueeze of the window",
    ),
    "Source": (
        *_SCENE_SETTINGS,
        *("channel", "convention", "near", "far", "kind", "scene unit", "in metres"),
        *("colour layer", "remove fireflies", "highlights", "neighbours"),
    ),
    "Timeline": (
        *("frame", "timecode", "frames per second", "ending", "pace", "missing frames"),
        *("auto key", "curve", "interpolation"),
    ),
}
# Panels of earlier versions, each with the panel where its controls are now.
FORMER_PANELS = {
    "Plan": "Marks",
    "Guides": "Display",
    "Plate": "Source",
    "Scene": "Source",
    "Speed": "Lens",
}


_FORMER_NAMES = {
    panel: tuple(name for name, place in FORMER_PANELS.items() if place == panel)
    for panel in SETTINGS
}
_SYNONYMS = {
    **dict.fromkeys(("never blur", "only blur", "flat depth"), ("matte", "Cryptomatte", "mask")),
    "frame mask": ("letterbox", "matte"),
    "focus peaking": ("edges in focus",),
    "f-stop": ("aperture", "iris"),
    "T-stop": ("aperture",),
    "focal length": ("zoom",),
    "squeeze": ("anamorphic",),
    "tilt": ("swing", "Scheimpflug"),
    "blades": ("bokeh", "iris"),
    "cat's eye": ("vignetting",),
    "axial colour": ("fringes", "chromatic aberration"),
    "sensor width": ("film back", "gate"),
    "the view breathes": ("breathing",),
    "neighbours": ("clean plate", "hidden surfaces"),
    "sharp up to": ("DoF", "circle of confusion"),
    "remove fireflies": ("bright grains",),
    "channel": ("AOV", "pass"),
    "display": ("LUT", "OCIO"),
    "view": ("LUT", "tone mapping"),
}


def setting_places(board: Board, control: TimeControl, ui: UiState) -> tuple[Command, ...]:
    """Return a command for each setting, and for each former panel, which shows its place."""
    places = [(panel, words) for panel, settings in SETTINGS.items() for words in settings]
    return tuple(
        Command(
            words,
            partial(_open_panel, ui, panel, words),
            menu=f"{panel} tab",
            barred=partial(_why_not, board, control, panel, words),
            synonyms=(*_SYNONYMS.get(words, ()), *_FORMER_NAMES.get(panel, ())),
        )
        for panel, words in (*places, *((panel, name) for name, panel in FORMER_PANELS.items()))
    )


def _why_not(board: Board, control: TimeControl, panel: str, words: str) -> str:
    """Return the reason why a setting of a panel is unavailable; "" if it is not."""
    if panel == "Source" and words in _SCENE_SETTINGS and not board.facts.has_camera:
        return "Only a scene has this setting, and none is open."
    if panel == "Timeline" and not control.timeline.has_time:
        return "A timeline needs a source with several frames."
    return ""


def _open_panel(ui: UiState, panel: str, words: str) -> None:
    """Open a panel, and bring its setting of these words into view."""
    ui.panels[panel] = True
    show_setting(panel, words)


def settings(board: Board, views: tuple[str, ...], ui: UiState) -> tuple[Command, ...]:
    """Return a command for each value that a setting can have; `views` are those of the display."""

    def why_barred(method: Method) -> str:
        return barred_methods(board.facts.has_many_views).get(str(method), "")

    def value_action(
        name: str, current: Callable[[], Changeable], field: str = "", **values: object
    ) -> Command:
        """Return a command that sets one field of the lens, blur or view."""
        return Command(
            f"Set {name}", lambda: board.choose(_with_values(current(), field, values)), menu=_MENU
        )

    lens, view = (lambda: board.facts.lens), (lambda: board.facts.view)
    blur = lambda: board.facts.shot.defocus  # noqa: E731
    peaking_action = partial(
        value_action, current=lambda: replace(board.facts.view, is_peaking=True), field="peaking"
    )
    methods = [(it, value_action(f"method {it}", blur, method=it)) for it in Method]
    squeezes = SQUEEZES.items()
    return (
        *(value_action(f"quality {it}", blur, quality=it) for it in Quality),
        *(value_action(f"bokeh {it}", blur, bokeh=it) for it in Bokeh),
        *(
            value_action(f"film back {it.name}", lens, sensor_width_mm=it.width_mm)
            for it in FILMBACKS
        ),
        *(value_action(f"view {it}", view, view=it) for it in views),
        *(value_action(f"overlay {it}", view, overlay=it) for it in overlays_by_name()),
        *(peaking_action(f"focus peaking {it}", color=it) for it in PEAKING_COLORS),
        *(peaking_action(f"focus peaking {it}", on=it) for it in PeakingOn),
        *(
            value_action(f"guides desqueeze {n}", view, "guides", desqueeze=it)
            for n, it in squeezes
        ),
        *(replace(command, barred=partial(why_barred, method)) for method, command in methods),
        *(Command(f"Set theme {it}", partial(ui.theme.choose, it), menu=_MENU) for it in Theme),
    )


def _with_values(current: Changeable, field: str, values: Values) -> Changeable:
    """Return lens, blur or view with these values, or with these values in one of its fields."""
    if field:
        values = {field: replace(getattr(current, field), **values)}
    return replace(current, **values)

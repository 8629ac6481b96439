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
from heatlens.studio.board.desks import TimeDesk
from heatlens.studio.board.facts import Facts
from heatlens.studio.settings.preferences import Theme
from heatlens.studio.ui.seek import show_setting
from heatlens.studio.ui.state import UiState

_MENU = "Setting"
SETTINGS: dict[str, tuple[str, ...]] = {
    "Lens": (
        *(option.label for option in options_of(Aperture).values()),
        *("distance", "f-stop", "T-stop", "focal length", "framing", "film back", "sensor width"),
        *("sharp up to", "lens model", "distances from", "pupil offset", "kit", "lens"),
        *("the view breathes", "at f-stop", "method", "bokeh", "quality", "layers"),
        *("parts", "picture size", "views", "rays a pixel", "source", "the lens follows it"),
    ),
    "Display": (
        *("display", "view", "input", "exposure", "gamma"),
        *("overlay", "compare", "gain", "compare with"),
    ),
    "Plate": (
        *("channel", "convention", "near", "far", "kind", "scene unit", "in metres"),
        *("colour layer", "take out bright grains", "highlights", "flat depth"),
        *("never blur", "only blur", "neighbours"),
    ),
    "Scene": ("camera", "clip", "size", "up axis", "unit"),
    "Export": (
        *(option.label for option in options_of(ExportOptions).values() if option.label),
        *("folder", "name", "where", "processes", "as", "at quality", "for"),
        "guides and desqueeze of the window",
    ),
    "Marks": ("close focus", *(option.label for option in options_of(Follow).values())),
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


def setting_places(facts: Facts, desk: TimeDesk, ui: UiState) -> tuple[Command, ...]:
    """Return a command for each setting, which shows the setting in its panel."""
    return tuple(
        Command(
            words,
            partial(_open_panel, ui, panel, words),
            menu=f"{panel} tab",
            barred=partial(_why_not, facts, desk, panel),
        )
        for panel, settings in SETTINGS.items()
        for words in settings
    )


def _why_not(facts: Facts, desk: TimeDesk, panel: str) -> str:
    """Return the reason why the settings of a panel are unavailable; "" if they are not."""
    if panel == "Scene" and not facts.has_camera:
        return "Only a scene has these settings, and none is open."
    if panel == "Timeline" and not desk.timeline.has_time:
        return "A timeline needs a source with several frames."
    return ""


def _open_panel(ui: UiState, panel: str, words: str) -> None:
    ui.panels[panel] = True
    show_setting(panel, words)


def settings(
    board: Board, facts: Facts, views: tuple[str, ...], ui: UiState
) -> tuple[Command, ...]:
    """Return a command for each value that a setting can have; `views` are those of the display."""

    def why_barred(method: Method) -> str:
        return barred_methods(facts.has_many_views).get(str(method), "")

    def value_action(
        name: str, current: Callable[[], Changeable], field: str = "", **values: object
    ) -> Command:
        return Command(
            f"Set {name}", lambda: board.choose(_with_values(current(), field, values)), menu=_MENU
        )

    lens, blur, view = (lambda: facts.lens), (lambda: facts.shot.defocus), (lambda: facts.view)
    peaking_action = partial(
        value_action, current=lambda: replace(facts.view, is_peaking=True), field="peaking"
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

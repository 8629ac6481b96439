"""Offer the settings of the panels as actions, so that the palette finds them.

The palette shows a setting in its panel by its label, or chooses one of its values. A test draws
the panels and checks that the labels here are those that are drawn.
"""

from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial

from heatlens.export.options import ExportOptions
from heatlens.model.aperture import Aperture
from heatlens.model.filmback import FILMBACKS
from heatlens.model.guides import SQUEEZES
from heatlens.model.option import options_of
from heatlens.model.peaking import PEAKING_COLORS, PeakingOn
from heatlens.model.settings import Bokeh, DefocusSettings, Method, Quality, barred_methods
from heatlens.model.view import Overlay, ViewState
from heatlens.session.door.door import Changeable, Door
from heatlens.session.facts import Facts
from heatlens.session.settings.preferences import Theme
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
        *("display", "view", "input", "exposure", "gamma"),
        *("overlay", "compare", "gain", "compare with"),
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


_MENU = "Setting"
Choice = tuple[str, Callable[[], Changeable]]  # a value's name, and the settings with it


def settings(door: Door, facts: Facts, views: tuple[str, ...], ui: UiState) -> tuple[Action, ...]:
    """Return an action for each value that a setting can have; `views` are those of the display."""

    def barred(method: Method) -> str:
        return barred_methods(facts.has_many_views).get(str(method), "")

    return (
        *(_action(door, *choice) for choice in (*_lens(facts), *_view(facts, views))),
        *(replace(_action(door, *_method(facts, it)), barred=partial(barred, it)) for it in Method),
        *(Action(f"Set theme {it}", _MENU, partial(ui.theme.choose, it)) for it in Theme),
    )


def _action(door: Door, name: str, changed: Callable[[], Changeable]) -> Action:
    return Action(f"Set {name}", _MENU, lambda: door.choose(changed()))


def _blur(facts: Facts, **changes: Quality | Bokeh | Method) -> Callable[[], DefocusSettings]:
    return lambda: replace(facts.shot.defocus, **changes)  # type: ignore[arg-type]  # any field


def _method(facts: Facts, method: Method) -> Choice:
    return f"method {method}", _blur(facts, method=method)


def _lens(facts: Facts) -> Iterator[Choice]:
    for quality in Quality:
        yield f"quality {quality}", _blur(facts, quality=quality)
    for bokeh in Bokeh:
        yield f"bokeh {bokeh}", _blur(facts, bokeh=bokeh)
    for back in FILMBACKS:
        width_mm = back.width_mm
        yield f"film back {back.name}", partial(_with_width, facts, width_mm)


def _with_width(facts: Facts, width_mm: float) -> Changeable:
    return replace(facts.lens, sensor_width_mm=width_mm)


def _view(facts: Facts, views: tuple[str, ...]) -> Iterator[Choice]:
    def viewed(change: Callable[[ViewState], ViewState]) -> Callable[[], ViewState]:
        return lambda: change(facts.view)

    for name in views:
        yield f"view {name}", viewed(partial(replace, view=name))
    for overlay in Overlay:
        yield f"overlay {overlay}", viewed(partial(replace, overlay=overlay))
    for name in PEAKING_COLORS:
        yield f"focus peaking {name}", viewed(partial(_peaked, color=name))
    for on in PeakingOn:
        yield f"focus peaking {on}", viewed(partial(_peaked, on=on))
    for name, squeeze in SQUEEZES.items():
        yield f"guides desqueeze {name}", viewed(partial(_desqueezed, squeeze=squeeze))


def _peaked(view: ViewState, **changes: str) -> ViewState:
    peaking = replace(view.peaking, **changes)  # type: ignore[arg-type]  # a color or what it is on
    return replace(view, peaking=peaking, is_peaking=True)


def _desqueezed(view: ViewState, squeeze: float | None) -> ViewState:
    return replace(view, guides=replace(view.guides, desqueeze=squeeze))

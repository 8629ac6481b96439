"""Offer the choices of the panels as actions, so that the palette finds them."""

from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial

from heatlens.model.filmback import FILMBACKS
from heatlens.model.guides import SQUEEZES
from heatlens.model.peaking import PEAKING_COLORS, PeakingOn
from heatlens.model.settings import Bokeh, DefocusSettings, Method, Quality, barred_methods
from heatlens.model.view import Overlay, ViewState
from heatlens.session.door.door import Changeable, Door
from heatlens.session.facts import Facts
from heatlens.session.settings.preferences import Theme
from heatlens.ui.actions import Action
from heatlens.ui.state import UiState

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

"""Offer the choices of the panels as actions, so that the palette finds them."""

from dataclasses import replace
from functools import partial
from typing import Any

from heatlens.model.filmback import FILMBACKS
from heatlens.model.guides import SQUEEZES
from heatlens.model.peaking import PEAKING_COLORS, PeakingOn
from heatlens.model.settings import Bokeh, Method, Quality
from heatlens.model.view import Overlay
from heatlens.session.session import Session
from heatlens.session.settings.preferences import Theme
from heatlens.ui.actions import Action
from heatlens.ui.panels.lens_panel import barred_methods
from heatlens.ui.state import UiState

_MENU = "Setting"


def settings(session: Session, ui: UiState) -> tuple[Action, ...]:
    """Return an action for each value that a setting can have."""
    return (
        *(_blur(session, f"quality {it}", "quality", it) for it in Quality),
        *(_blur(session, f"bokeh {it}", "bokeh", it) for it in Bokeh),
        *(_method(session, method) for method in Method),
        *(_film_back(session, back.name, back.width_mm) for back in FILMBACKS),
        *(
            _view(session, name)
            for name in session.pictures.color.views(session.facts.view.display)
        ),
        *(_viewed(session, f"overlay {it}", overlay=it) for it in Overlay),
        *(_peaking(session, name, color=name) for name in PEAKING_COLORS),
        *(_peaking(session, str(it), on=it) for it in PeakingOn),
        *(_desqueeze(session, name, value) for name, value in SQUEEZES.items()),
        *(Action(f"Set theme {it}", _MENU, partial(ui.theme.choose, it)) for it in Theme),
    )


def _blur(session: Session, name: str, field: str, value: Any) -> Action:
    def change() -> None:
        shot = session.facts.shot
        session.editing.do(replace(shot, defocus=replace(shot.defocus, **{field: value})))

    return Action(f"Set {name}", _MENU, change)


def _method(session: Session, method: Method) -> Action:
    def why_not() -> str:
        return barred_methods(session.facts.has_many_views).get(str(method), "")

    made = _blur(session, f"method {method}", "method", method)
    return replace(made, barred=why_not)


def _film_back(session: Session, name: str, width_mm: float) -> Action:
    def change() -> None:
        session.editing.settle()
        session.editing.edit_lens(replace(session.facts.lens, sensor_width_mm=width_mm))
        session.editing.settle()

    return Action(f"Set film back {name}", _MENU, change)


def _viewed(session: Session, name: str, **changes: Any) -> Action:
    return Action(f"Set {name}", _MENU, partial(session.pictures.commands.change, **changes))


def _peaking(session: Session, name: str, **changes: Any) -> Action:
    peaking = replace(session.facts.view.peaking, **changes)
    return _viewed(session, f"focus peaking {name}", peaking=peaking, is_peaking=True)


def _desqueeze(session: Session, name: str, value: float) -> Action:
    guides = replace(session.facts.view.guides, desqueeze=value)
    return _viewed(session, f"guides desqueeze {name}", guides=guides)


def _view(session: Session, name: str) -> Action:
    return Action(f"Set view {name}", _MENU, partial(session.pictures.commands.change, view=name))

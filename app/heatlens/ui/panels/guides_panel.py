"""Guides: mattes and lines over the picture, and the coloured edges of what is in focus."""

from collections.abc import Callable
from dataclasses import replace

from imgui_bundle import imgui

from heatlens.model.guides import MATTES, Guides, parse_aspect
from heatlens.model.view import Overlay, ViewState
from heatlens.ui import probe, widgets

_NO_MATTE, _OWN = "none", "own"
_OWN_FIRST = 2.0  # width over height, until another is typed
_LINES = (("safe_areas", "safe areas"), ("thirds", "thirds"), ("centre", "centre cross"))


def guides_panel(view: ViewState, say: Callable[[str], None]) -> ViewState:
    """Draw it; return the view as the user left it."""
    imgui.separator_text("Matte and lines")
    guides = _matte(view.guides, say)
    for field, words in _LINES:
        guides = replace(guides, **{field: _check(words, bool(getattr(guides, field)))})
    imgui.separator_text("Focus peaking")
    return _peaking(replace(view, guides=guides))


def _matte(guides: Guides, say: Callable[[str], None]) -> Guides:
    known = {aspect: name for name, aspect in MATTES.items()}
    shown = _NO_MATTE if guides.aspect is None else known.get(guides.aspect, _OWN)
    tip = "Darkens what another aspect would cut off."
    picked = widgets.choice("matte", shown, [_NO_MATTE, *MATTES, _OWN], tip)
    if picked != shown:
        aspect = {_NO_MATTE: None, _OWN: _OWN_FIRST}.get(picked, MATTES.get(picked))
        return replace(guides, aspect=aspect)
    if shown != _OWN or guides.aspect is None:
        return guides
    widgets.label("own aspect", "Width over height: 2.2, 2.2:1 or 16:9")
    now = guides.aspect
    aspect = widgets.text_field("own aspect", f"{now:.4g}", now, parse_aspect, say)
    return replace(guides, aspect=aspect)


def _peaking(view: ViewState) -> ViewState:
    is_on = view.overlay is Overlay.PEAKING
    if _check("colour the edges in focus", is_on) is not is_on:
        view = replace(view, overlay=Overlay.NONE if is_on else Overlay.PEAKING)
    tip = "Edges of at least this contrast are coloured, where they are in focus."
    stops = widgets.slider("contrast", view.peaking_stops, 0.05, 3.0, "%.2f stops", tip)
    return replace(view, peaking_stops=stops)


def _check(words: str, value: bool) -> bool:
    _, value = imgui.checkbox(words, value)
    probe.note(words)
    return bool(value)

"""Draw frame masks, guide lines, desqueeze and focus peaking, as folds of the Display panel."""

from collections.abc import Callable
from dataclasses import replace

from imgui_bundle import imgui

from heatlens.core.base.outside_text import printable
from heatlens.core.model.option import Values
from heatlens.core.model.view.guides import (
    BLUR_RANGE,
    MATTES,
    PEAKING_COLORS,
    SQUEEZES,
    STOPS_RANGE,
    Guides,
    Peaking,
    PeakingOn,
    parse_aspect,
    parse_desqueeze,
)
from heatlens.core.model.view.view import ViewState
from heatlens.studio.ui import widgets
from heatlens.studio.ui.seek import is_highlighted

_OWN = "own"
_AS_FILE, _SQUARE = "as the file says", "square pixels"
_OWN_SQUEEZE_START = 1.6
_OWN_ASPECT_START = 2.0  # first aspect ratio, width over height, of an own mask
_GUIDE_ROWS = (
    *("frame mask", "own aspect", "opacity", "safe areas", "thirds", "centre cross", "framing"),
    *("desqueeze", "own desqueeze", "Guides"),
)
_PEAKING_ROWS = ("show", "colour", "contrast", "up to")
_LINES = (("safe_areas", "safe areas"), ("thirds", "thirds"), ("centre", "centre cross"))


def guides_rows(view: ViewState, squeeze: float, notify: Callable[[str], None]) -> ViewState:
    """Draw the fold; return the view as the user left it. `squeeze` is that of the lens."""
    guides = view.guides
    if not widgets.folded_header("Frame masks and guides", _GUIDE_ROWS):
        return view
    guides = _mask_rows(guides, notify)
    for field, words in _LINES:
        changes: Values = {field: widgets.check(words, bool(getattr(guides, field)))}
        guides = replace(guides, **changes)
    guides = _desqueeze_rows(_framing_row(guides), squeeze, notify)
    return replace(view, guides=guides)


def _framing_row(guides: Guides) -> Guides:
    """Draw the names of the framing lines, with a button to remove them."""
    names = {line.name: None for canvas in guides.canvases for line in canvas.lines}
    if not names:
        return guides
    widgets.label("framing", "Of a framing decision list: File > Import > Import framing lines...")
    if widgets.small_button("x##no framing", "no framing", "Put the framing lines away."):
        return replace(guides, canvases=())
    imgui.same_line()
    imgui.text_wrapped(printable(", ".join(names)))
    return guides


def _mask_rows(guides: Guides, notify: Callable[[str], None]) -> Guides:
    """Draw the choice of the frame mask, its own aspect ratio and its opacity."""
    names: dict[float | None, str] = {None: "none"}
    names |= {aspect: name for name, aspect in MATTES.items()}
    aspect_now, is_own = guides.aspect, guides.aspect not in names
    names |= {aspect_now if is_own else _OWN_ASPECT_START: _OWN}
    tip = "Darkens what another aspect ratio would cut off."
    picked_aspect = widgets.pick("frame mask", aspect_now, names, tip)
    if picked_aspect != aspect_now or aspect_now is None:
        return replace(guides, aspect=picked_aspect)
    if is_own:
        widgets.label("own aspect", "Width over height: 2.2, 2.2:1 or 16:9")
        aspect = widgets.text_field(
            "own aspect", f"{aspect_now:.4g}", aspect_now, parse_aspect, notify
        )
        guides = replace(guides, aspect=aspect)
    opacity = widgets.slider("opacity", guides.opacity, 0.0, 1.0, "%.2f", "1 is black.")
    return replace(guides, opacity=opacity)


def _desqueeze_rows(guides: Guides, squeeze: float, notify: Callable[[str], None]) -> Guides:
    """Draw the choice of the pixel aspect ratio for the view."""
    names = {value: name for name, value in SQUEEZES.items()}
    desqueeze_now = guides.desqueeze
    current_name = (
        _AS_FILE
        if desqueeze_now is None
        else _SQUARE
        if desqueeze_now == 1.0
        else names.get(desqueeze_now, _OWN)
    )
    tip = (
        "Width of a pixel over its height as shown. It changes the view and exports with guides, "
        "not the blur."
    )
    as_lens = f"as the lens: {squeeze:.4g}"
    lens_names = [as_lens] if squeeze != 1.0 else []
    picked_name = widgets.choice(
        "desqueeze", current_name, [_AS_FILE, *lens_names, _SQUARE, *SQUEEZES, _OWN], tip
    )
    if picked_name != current_name:
        values = {_AS_FILE: None, as_lens: squeeze, _SQUARE: 1.0, _OWN: _OWN_SQUEEZE_START}
        return replace(guides, desqueeze=values.get(picked_name, SQUEEZES.get(picked_name)))
    if current_name != _OWN or desqueeze_now is None:
        return guides
    widgets.label("own desqueeze", "2, 1.33 or 4:3")
    desqueeze = widgets.text_field(
        "own desqueeze", f"{desqueeze_now:.4g}", desqueeze_now, parse_desqueeze, notify
    )
    return replace(guides, desqueeze=desqueeze)


def peaking_rows(view: ViewState) -> ViewState:
    """Draw the switch of focus peaking, and its settings while it is on or sought."""
    view = replace(view, is_peaking=widgets.check("focus peaking", view.is_peaking))
    if not (view.is_peaking or any(is_highlighted(it, scrolls=False) for it in _PEAKING_ROWS)):
        return view
    peaking = view.peaking
    tip = "The visible edges of objects in focus, or everything whose distance is in focus."
    source = widgets.pick_one("show", peaking.on, tip)
    color = widgets.choice("colour", peaking.color, list(PEAKING_COLORS))
    stops = peaking.stops
    if source is PeakingOn.PICTURE:
        tip = "Edges of at least this contrast are coloured: a lower value finds more."
        stops = widgets.slider("contrast", stops, *STOPS_RANGE, "%.2f stops", tip)
    tip = "How large a blur still counts as in focus, in acceptable circles of confusion."
    blur = widgets.slider("up to", peaking.blur, *BLUR_RANGE, "%.2f x sharp", tip)
    return replace(view, peaking=Peaking(source, stops, blur, color))

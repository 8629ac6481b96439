"""Draw the Display panel: color, overlays, comparison, focus peaking, masks and guides."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

from heatlens.core.model.shot.grade import Grade
from heatlens.core.model.shot.settings import Method, barred_methods
from heatlens.core.model.view.overlays import overlays_by_name
from heatlens.core.model.view.view import GAIN_LEAST, GAIN_MOST, Against, Compare, ViewState
from heatlens.render.display.color_choice import ColorChoice
from heatlens.studio.ui import widgets
from heatlens.studio.ui.panels.guides_panel import guides_rows, peaking_rows
from heatlens.studio.ui.segments import segments

_PICTURE = "picture"  # in the list of channels: none of them
_COMPARE_NAMES: Mapping[Compare, str] = {
    Compare.OFF: "off",
    Compare.WIPE: "wipe",
    Compare.FLIP: "show B",
    Compare.DIFFERENCE: "difference",
}


def display_panel(
    view: ViewState,
    color: ColorChoice,
    reference: str | None,
    has_many_views: bool,
    notify: Callable[[str], None],
    grade: Grade | None = None,
    squeeze: float = 1.0,
    channels: Sequence[str] = (),
) -> ViewState:
    """Draw the panel; return the view as the user left it.

    `reference` is the name of its EXR, `squeeze` that of the lens, and `channels` are those of the
    plate's file.
    """
    view = _color_rows(_channel_row(view, channels), color)
    if grade is not None:
        view = replace(
            view, is_graded=widgets.check("grade", view.is_graded, tip=_grade_words(grade))
        )
    widgets.spacer()
    view = peaking_rows(_overlay_row(view))
    widgets.spacer()
    tip = "A beside B, B alone, or how they differ."
    compare = segments("compare", view.compare, _COMPARE_NAMES, 4, tip)
    view = _compare_rows(replace(view, compare=compare), reference, has_many_views, notify)
    return guides_rows(view, squeeze, notify)


def _overlay_row(view: ViewState) -> ViewState:
    """Draw a button for each overlay, with the name of its command; return the view."""
    overlays = overlays_by_name()
    labels = {name: overlay.label for name, overlay in overlays.items()}
    tips = {name: overlay.words for name, overlay in overlays.items()}
    tip = "Drawn over the picture, with a legend."
    return replace(view, overlay=segments("overlay", view.overlay, labels, 3, tip, tips))


def _channel_row(view: ViewState, channels: Sequence[str]) -> ViewState:
    """Draw the choice of the channel to look at in place of the picture; return the view."""
    if not channels:
        return view
    is_shown = view.against is Against.CHANNEL and view.compare is Compare.FLIP
    current = view.channel if is_shown else _PICTURE
    tip = "Any channel of the file: directions around grey, ids in colours, numbers by size."
    chosen = widgets.choice("channel", current, [_PICTURE, *channels], tip)
    if chosen == current:
        return view
    if chosen == _PICTURE:
        return replace(view, against=Against.PINHOLE, compare=Compare.OFF)
    return replace(view, against=Against.CHANNEL, compare=Compare.FLIP, channel=chosen)


def _grade_words(grade: Grade) -> str:
    """Return the numbers of a grade as text, a line for each."""
    numbers = zip(("slope", "offset", "power", "saturation"), str(grade).split(), strict=True)
    return "\n".join(("ASC CDL of the shot, before the view:", *map(" ".join, numbers)))


def _color_rows(view: ViewState, color: ColorChoice) -> ViewState:
    """Draw the rows of display, view, input space, exposure and gamma; return the changed view."""
    exposure = widgets.slider("exposure", view.exposure_stops, -8.0, 8.0, "%+.2f stops")
    gamma = widgets.slider("gamma", view.gamma, 0.2, 4.0, "%.2f")
    display = widgets.choice("display", view.display, color.displays())
    if display != view.display:
        view = replace(view, display=display, view=color.usual_view(display))
    view_name = widgets.choice("view", view.view, color.views(view.display))
    view = _input_row(view, color)
    return replace(view, view=view_name, exposure_stops=exposure, gamma=gamma)


def _input_row(view: ViewState, color: ColorChoice) -> ViewState:
    """Draw the choice of the input color space; the first choice is that of the plate's header."""
    space = color.plate_input_space("")
    auto = f"auto: {space.name}"
    tip = (
        "Colour space of the pictures. Auto: the space in the plate's header, or linear Rec.709, "
        f"the default of renderers. Now: {space.origin}."
    )
    chosen_space = widgets.choice(
        "input", view.input_space or auto, [auto, *color.input_spaces()], tip
    )
    return replace(view, input_space="" if chosen_space == auto else chosen_space)


def _compare_rows(
    view: ViewState, reference: str | None, has_many_views: bool, notify: Callable[[str], None]
) -> ViewState:
    """Draw the gain of the difference and the choice of B; return the changed view."""
    if view.compare is Compare.DIFFERENCE:
        gain_range = (GAIN_LEAST, GAIN_MOST)
        gain = widgets.drag("gain", view.difference_gain, 0.05, *gain_range, "x %.1f", notify)
        view = replace(view, difference_gain=gain)
    choices: dict[str, tuple[Against, Method]] = {"pinhole": (Against.PINHOLE, view.b_method)}
    if reference is not None:
        choices[reference] = (Against.REFERENCE, view.b_method)
    choices |= {f"method {method}": (Against.METHOD, method) for method in Method}
    if view.against is Against.LOOK:  # chosen in the Looks panel
        choices[f"look {view.b_look}"] = (Against.LOOK, view.b_method)
    if view.against is Against.CHANNEL:
        choices[f"channel {view.channel}"] = (Against.CHANNEL, view.b_method)
    if view.against is Against.SHOT:  # chosen in the Compare menu
        choices["another shot"] = (Against.SHOT, view.b_method)
    current = (view.against, view.b_method)
    current_name = next((name for name, value in choices.items() if value == current), "pinhole")
    tip = "The same shot by another method, or any EXR: Ctrl+Shift+O opens it."
    barred = {
        f"method {method}": reason for method, reason in barred_methods(has_many_views).items()
    }
    against, method = choices[
        widgets.choice("compare with", current_name, list(choices), tip, barred)
    ]
    return replace(view, against=against, b_method=method)

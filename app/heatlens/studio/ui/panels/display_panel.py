"""Draw the Display panel: colour, overlays and comparison."""

from collections.abc import Callable, Mapping
from dataclasses import replace

from imgui_bundle import imgui

from heatlens.core.model.option import Values
from heatlens.core.model.shot.grade import Grade
from heatlens.core.model.shot.settings import Method, barred_methods
from heatlens.core.model.view.overlays import overlays_by_name
from heatlens.core.model.view.view import GAIN_LEAST, GAIN_MOST, Against, Compare, ViewState
from heatlens.studio.session.pictures.picture_view import ColorChoice
from heatlens.studio.ui import probe, widgets

_COMPARES: Mapping[str, str] = {
    Compare.OFF: "off",
    Compare.WIPE: "wipe",
    Compare.FLIP: "B",
    Compare.DIFFERENCE: "difference",
}
_PER_ROW = {"overlay": 3, "compare": 4}
_RADIO_EM = 2.2  # width of a radio button and the gap after it, without its text


def display_panel(
    view: ViewState,
    color: ColorChoice,
    reference: str | None,
    has_many_views: bool,
    say: Callable[[str], None],
    grade: Grade | None = None,
) -> ViewState:
    """Draw the panel; return the view as the user left it. `reference` is the name of its EXR."""
    view = _color(view, color)
    if grade is not None:
        view = replace(view, is_graded=widgets.check("grade", view.is_graded, tip=_graded(grade)))
    imgui.separator()
    offered = {name: overlay.label for name, overlay in overlays_by_name().items()}
    view = _buttons(view, "overlay", offered, "Drawn over the picture, with a legend.")
    imgui.separator()
    view = _buttons(view, "compare", _COMPARES, "A beside B, B alone, or how they differ.")
    return _compare(view, reference, has_many_views, say)


def _graded(grade: Grade) -> str:
    numbers = zip(("slope", "offset", "power", "saturation"), str(grade).split(), strict=True)
    return "\n".join(("ASC CDL of the shot, before the view:", *map(" ".join, numbers)))


def _color(view: ViewState, color: ColorChoice) -> ViewState:
    display = widgets.choice("display", view.display, color.displays())
    if display != view.display:
        view = replace(view, display=display, view=color.usual_view(display))
    shown = widgets.choice("view", view.view, color.views(view.display))
    view = _input(view, color)
    exposure = widgets.slider("exposure", view.exposure_stops, -8.0, 8.0, "%+.2f stops")
    gamma = widgets.slider("gamma", view.gamma, 0.2, 4.0, "%.2f")
    return replace(view, view=shown, exposure_stops=exposure, gamma=gamma)


def _input(view: ViewState, color: ColorChoice) -> ViewState:
    """Draw the choice of the input colour space; the first is the one the plate itself names."""
    space = color.input_of("")
    auto = f"auto: {space.name}"
    tip = (
        "Colour space of the pictures. Auto: the space in the plate's header, or linear Rec.709, "
        f"the default of renderers. Now: {space.why}."
    )
    chosen = widgets.choice("input", view.input_space or auto, [auto, *color.input_spaces()], tip)
    return replace(view, input_space="" if chosen == auto else chosen)


def _buttons(view: ViewState, field: str, names: Mapping[str, str], tip: str) -> ViewState:
    """Draw a field of the view as radio buttons in even columns beside the label."""
    widgets.label(field, tip)
    left, em = imgui.get_cursor_pos_x(), imgui.get_font_size()
    per_row = _PER_ROW[field]
    widths = [imgui.calc_text_size(name).x + _RADIO_EM * em for name in names.values()]
    columns = [max(widths[i::per_row]) for i in range(per_row)]
    for index, (value, name) in enumerate(names.items()):
        at = left + sum(columns[: index % per_row])
        if index % per_row:
            imgui.same_line(at)
        else:
            imgui.set_cursor_pos_x(at)
        if imgui.radio_button(f"{name}##{field}", getattr(view, field) == value):
            chosen: Values = {field: value}
            view = replace(view, **chosen)
        probe.note(f"{field} {name}")
    return view


def _compare(
    view: ViewState, reference: str | None, has_many_views: bool, say: Callable[[str], None]
) -> ViewState:
    if view.compare is Compare.DIFFERENCE:
        ends = (GAIN_LEAST, GAIN_MOST)
        gain = widgets.drag("gain", view.difference_gain, 0.05, *ends, "x %.1f", say)
        view = replace(view, difference_gain=gain)
    choices: dict[str, tuple[Against, Method]] = {"pinhole": (Against.PINHOLE, view.b_method)}
    if reference is not None:
        choices[reference] = (Against.REFERENCE, view.b_method)
    choices |= {f"method {method}": (Against.METHOD, method) for method in Method}
    if view.against is Against.LOOK:  # chosen in the Looks panel
        choices[f"look {view.b_look}"] = (Against.LOOK, view.b_method)
    now = (view.against, view.b_method)
    shown = next((name for name, value in choices.items() if value == now), "pinhole")
    tip = "The same shot by another method, or any EXR: Ctrl+Shift+O opens it."
    barred = {f"method {method}": why for method, why in barred_methods(has_many_views).items()}
    against, method = choices[widgets.choice("compare with", shown, list(choices), tip, barred)]
    return replace(view, against=against, b_method=method)

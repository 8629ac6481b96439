"""Draw the row of key controls: set a key, auto key, curve, interpolation and easing."""

from collections.abc import Sequence
from functools import partial

from imgui_bundle import imgui

from heatlens.model.curve import Key
from heatlens.model.interpolation import Interpolation
from heatlens.model.shot import LensParameter
from heatlens.session.desks import TimeDesk
from heatlens.session.keys.key_choice import key_of
from heatlens.session.keys.key_rows import CAMERA
from heatlens.ui import probe, widgets
from heatlens.ui.timeline.tool_row import Tool, button_width, checkbox_width, tool_row
from heatlens.ui.timeline.transport import combo
from heatlens.ui.timeline.view import TimelineView

_MIXED = "mixed"
_SET_TIPS = {
    False: "Set a key for the focus and every parameter that has keys (K)",
    True: "Set a key for the camera at this frame (K)",
}
_EASE_EM, _INTERPOLATION_EM, _CURVE_OF_EM = 6.2, 6.0, 8.4


def keys_row(desk: TimeDesk, view: TimelineView) -> None:
    """Draw the row; controls of chosen keys are disabled while there are none."""
    em, rows = imgui.get_font_size(), desk.keys.rows
    found = [k for one in desk.keys.meant if (k := key_of(desk.editing.shot, one)) is not None]
    note = _selection_note(desk)
    tools = [
        Tool(partial(_set_key, desk), button_width("Set key"), 0),
        Tool(partial(_auto_key, desk), checkbox_width("auto key"), 1),
        Tool(partial(_shows_curve, desk), checkbox_width("curve"), 1),
        Tool(partial(_interpolation, desk, found), _INTERPOLATION_EM * em, 3),
        Tool(partial(_ease, desk, found, "ease out", True), _EASE_EM * em, 4),
        Tool(partial(_ease, desk, found, "ease in", False), _EASE_EM * em, 4),
        Tool(partial(_words, note), imgui.calc_text_size(note).x, 5, is_word=True),
    ]
    if rows.shows_curve:
        tools.insert(3, Tool(partial(_curve_of, desk, view), _CURVE_OF_EM * em, 2))
    tool_row("keys", tools)


def _set_key(desk: TimeDesk) -> None:
    if widgets.button("Set key", "set key", _SET_TIPS[desk.keys.rows.chosen is CAMERA]):
        desk.keys.set_here()


def _auto_key(desk: TimeDesk) -> None:
    tip = "Set a key whenever a parameter with keys is changed (A)"
    desk.editing.auto_key = widgets.check("auto key", desk.editing.auto_key, tip=tip)


def _shows_curve(desk: TimeDesk) -> None:
    rows = desk.keys.rows
    tip = "Show the selected row as a curve, or all keys in rows (Shift+C)"
    rows.shows_curve = widgets.check("curve", rows.shows_curve, tip=tip)


def _curve_of(desk: TimeDesk, view: TimelineView) -> None:
    rows = desk.keys.rows
    chosen = combo("curve of", rows.curve_of, {it: it.words for it in LensParameter})
    if chosen is not rows.curve_of:
        rows.choose(chosen)
        view.heights = None


def _interpolation(desk: TimeDesk, found: Sequence[Key]) -> None:
    """Draw the interpolation after the chosen keys; the camera has only one."""
    kinds = {key.interpolation for key in found}
    now = kinds.pop() if len(kinds) == 1 else None
    words: dict[Interpolation | None, str] = {it: str(it) for it in Interpolation}
    with widgets.disabled(not found):
        picked = combo("interpolation", now, words, _MIXED if found else "")
    if picked is not None and picked is not now:
        desk.keys.interpolate(picked)


def _ease(desk: TimeDesk, found: Sequence[Key], name: str, is_out: bool) -> None:
    """Draw the length of the handles of the chosen keys on one side."""
    eases = [key.ease_out if is_out else key.ease_in for key in found]
    percent = eases[0].influence_percent if eases else 0.0
    with widgets.disabled(not found):
        changed, new = imgui.drag_float(
            f"##{name}", percent, 0.5, 0.0, 100.0, f"{name} %.0f %%",
            imgui.SliderFlags_.always_clamp,
        )  # fmt: skip
        probe.note(name)
        widgets.tooltip("How far the handle reaches; the segment becomes a Bezier")
    if changed:
        desk.keys.ease(new, is_out)


def _selection_note(desk: TimeDesk) -> str:
    count = len(desk.keys.chosen)
    return f"{count} chosen" if count else "key here" if desk.keys.meant else "no key here"


def _words(words: str) -> None:
    imgui.align_text_to_frame_padding()
    imgui.text_disabled(words)

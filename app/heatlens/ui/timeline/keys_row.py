"""Draw the row of key controls: set a key, auto key, curve, interpolation and easing."""

from collections.abc import Sequence
from functools import partial

from imgui_bundle import imgui

from heatlens.model.curves.curve import Key
from heatlens.model.curves.interpolation import Interpolation
from heatlens.model.shot.shot import LensParameter
from heatlens.session.desks import TimeDesk
from heatlens.session.keys.key_choice import key_of
from heatlens.session.keys.key_rows import CAMERA
from heatlens.ui import probe, widgets
from heatlens.ui.timeline.tool_row import Tool, push, tick, tool_row, word
from heatlens.ui.timeline.transport import combo
from heatlens.ui.timeline.view import TimelineView

_MIXED = "mixed"
_SET_TIPS = {
    False: "Set a key for the focus and every parameter that has keys (K)",
    True: "Set a key for the camera at this frame (K)",
}
_AUTO_KEY_TIP = "Set a key whenever a parameter with keys is changed (A)"
_CURVE_TIP = "Show the selected row as a curve, or all keys in rows (Shift+C)"
_EASE_EM, _INTERPOLATION_EM, _CURVE_OF_EM = 6.2, 6.0, 8.4


def keys_row(desk: TimeDesk, view: TimelineView) -> None:
    """Draw the row; controls of chosen keys are disabled while there are none."""
    em, rows = imgui.get_font_size(), desk.keys.rows
    found = [k for one in desk.keys.meant if (k := key_of(desk.editing.shot, one)) is not None]
    tools = [
        push("Set key", "set key", 0, desk.keys.set_here, _SET_TIPS[rows.chosen is CAMERA]),
        tick("auto key", desk.editing, "auto_key", 1, _AUTO_KEY_TIP),
        tick("curve", rows, "shows_curve", 1, _CURVE_TIP),
        Tool(partial(_interpolation, desk, found), _INTERPOLATION_EM * em, 3),
        Tool(partial(_ease, desk, found, "ease out", True), _EASE_EM * em, 4),
        Tool(partial(_ease, desk, found, "ease in", False), _EASE_EM * em, 4),
        word(_selection_note(desk), 5),
    ]
    if rows.shows_curve:
        tools.insert(3, Tool(partial(_curve_of, desk, view), _CURVE_OF_EM * em, 2))
    tool_row("keys", tools)


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

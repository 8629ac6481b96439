"""Draw the row of key controls: set a key, auto key, curve, interpolation and easing."""

from collections.abc import Sequence

from imgui_bundle import imgui

from heatlens.model.curve import Key
from heatlens.model.interpolation import Interpolation
from heatlens.model.shot import LensParameter
from heatlens.session.key_choice import key_of
from heatlens.session.key_rows import CAMERA
from heatlens.session.session import Session
from heatlens.ui import probe, widgets
from heatlens.ui.timeline.transport import beside, combo
from heatlens.ui.timeline.view import TimelineView

_MIXED = "mixed"
_SET_TIPS = {
    False: "Set a key for the focus and every parameter that has keys (K)",
    True: "Set a key for the camera at this frame (K)",
}
_EASE_EM, _INTERPOLATION_EM, _CURVE_OF_EM = 6.2, 6.0, 7.6


def keys_row(session: Session, view: TimelineView) -> None:
    """Draw the row; controls of chosen keys are disabled while there are none."""
    rows = session.keys.rows
    if imgui.button("Set key"):
        session.keys.set_here()
    probe.note("set key")
    _tip(_SET_TIPS[rows.chosen is CAMERA])
    imgui.same_line()
    _, session.editing.auto_key = imgui.checkbox("auto key", session.editing.auto_key)
    probe.note("auto key")
    _tip("Set a key whenever a parameter with keys is changed (A)")
    imgui.same_line()
    _, rows.shows_curve = imgui.checkbox("curve", rows.shows_curve)
    probe.note("curve")
    _tip("Show the selected row as a curve, or all keys in rows (Shift+C)")
    if rows.shows_curve:
        _curve_of(session, view)
    found = [k for one in session.keys.meant if (k := key_of(session.shot, one)) is not None]
    with widgets.disabled(not found):  # the camera has only one interpolation
        _interpolation(session, found)
    _selection_note(session)


def _curve_of(session: Session, view: TimelineView) -> None:
    """Draw the choice of the parameter whose curve is shown."""
    rows = session.keys.rows
    names = {parameter.words: parameter for parameter in LensParameter}
    chosen = names[combo("curve of", rows.curve_of.words, list(names), _CURVE_OF_EM)]
    if chosen is not rows.curve_of:
        rows.choose(chosen)
        view.heights = None


def _interpolation(session: Session, found: Sequence[Key]) -> None:
    keys = session.keys
    words = {str(key.interpolation) for key in found}
    shown = words.pop() if len(words) == 1 else (_MIXED if words else "")
    picked = combo("interpolation", shown, [str(i) for i in Interpolation], _INTERPOLATION_EM)
    if picked != shown:
        keys.interpolate(Interpolation(picked))
    for name, is_out in (("ease out", True), ("ease in", False)):
        eases = [key.ease_out if is_out else key.ease_in for key in found]
        percent = eases[0].influence_percent if eases else 0.0
        beside(_EASE_EM)
        changed, new = imgui.drag_float(
            f"##{name}", percent, 0.5, 0.0, 100.0, f"{name} %.0f %%",
            imgui.SliderFlags_.always_clamp,
        )  # fmt: skip
        probe.note(name)
        _tip("How far the handle reaches; the segment becomes a Bezier")
        if changed:
            keys.ease(new, is_out)


def _selection_note(session: Session) -> None:
    keys = session.keys
    count = len(keys.chosen)
    note = f"{count} chosen" if count else "key here" if keys.meant else "no key here"
    imgui.same_line()
    if imgui.get_content_region_avail().x >= imgui.calc_text_size(note).x:
        imgui.align_text_to_frame_padding()
        imgui.text_disabled(note)
    else:
        imgui.new_line()


def _tip(text: str) -> None:
    if imgui.is_item_hovered(imgui.HoveredFlags_.for_tooltip):
        imgui.set_tooltip(text)

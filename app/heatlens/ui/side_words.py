"""Words of the status bar: what the mouse does, and at its right end what A and B are."""

from imgui_bundle import imgui

from heatlens.model.view import Against, Compare, ViewState
from heatlens.preview.shown import Shown
from heatlens.printable import printable
from heatlens.session.compare_sides import CompareSides
from heatlens.ui import probe


def mouse_words(has_camera: bool) -> str:
    """Return what the mouse does in the picture; `has_camera`: it moves one, as in a scene."""
    if not has_camera:
        return "Click in the picture to focus"
    return "Click to focus.  Right drag orbits, with Ctrl it moves aside; Ctrl+wheel goes nearer"


def words(view: ViewState, sides: CompareSides, reference: str | None, shown: Shown | None) -> str:
    """Return "A: diffusion    B: gather"; A alone where B is not seen.

    `reference`: the EXR's name; `shown`: the picture that is A.
    """
    if shown is None:
        return ""
    a = side_words(shown) if view.depth_of_field else "pinhole"
    if view.compare is Compare.OFF:
        return a
    if view.compare is Compare.GRID:
        return "looks beside each other"
    if view.a_look and sides.of_a(view) is not None:
        a = f"look {view.a_look}"
    return f"A: {a}    B: {_b_words(view, sides.of_method(view), reference)}"


def side_words(shown: Shown) -> str:
    """Return how a picture was made, and how far it is: "raytraced, 16 of 256 views"."""
    made, wished = shown.settings, shown.shot.defocus
    if wished.method.needs_scene and made.views < wished.views:
        return f"{wished.method}, {made.views} of {wished.views} views"
    return str(wished.method) if shown.is_whole else f"{wished.method}, preview"


def _b_words(view: ViewState, of_method: Shown | None, reference: str | None) -> str:
    if view.against is Against.LOOK and of_method is not None:
        return f"look {view.b_look}"
    if of_method is not None:
        return side_words(of_method)
    if view.against is Against.REFERENCE and reference is not None:
        return reference
    return "pinhole"


def draw_sides(text: str) -> None:
    """Draw the words of A and B at the right end of the line of the last item."""
    em = imgui.get_font_size()
    left = imgui.get_window_width() - imgui.calc_text_size(text).x - 0.6 * em
    if text:
        imgui.same_line(left)
        imgui.text_disabled(printable(text))
        probe.note("sides")

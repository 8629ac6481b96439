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
        a = _look_words(view.a_look, sides)
    return f"A: {a}    B: {_b_words(view, sides, reference)}"


def _look_words(name: str, sides: CompareSides) -> str:
    """Return which look is seen, and whether that is not the whole picture yet."""
    return f"look {name}, preview" if sides.is_coming(name) else f"look {name}"


def side_words(shown: Shown) -> str:
    """Return how a picture was made, and how far it is: "raytraced, 16 of 256 views"."""
    made, wished = shown.settings, shown.shot.defocus
    if wished.method.needs_scene and made.views < wished.views:
        return f"{wished.method}, {made.views} of {wished.views} views"
    return str(wished.method) if shown.is_whole else f"{wished.method}, preview"


def _b_words(view: ViewState, sides: CompareSides, reference: str | None) -> str:
    of_method = sides.of_method(view)
    if view.against is Against.LOOK and of_method is not None:
        return _look_words(view.b_look, sides)
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

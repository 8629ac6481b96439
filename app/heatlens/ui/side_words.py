"""Write the texts of the status bar: the mouse gestures, and the names of sides A and B."""

from imgui_bundle import imgui

from heatlens.base.printable import printable
from heatlens.model.view import Against, Compare, ViewState
from heatlens.preview.shown import Shown
from heatlens.session.pictures.compare_sides import CompareSides
from heatlens.ui import probe


def mouse_words(has_camera: bool) -> str:
    """Return what the mouse does in the picture; `has_camera` adds the gestures of a scene."""
    if not has_camera:
        return "Click in the picture to focus"
    return "Click to focus.  Right drag orbits, with Ctrl it moves aside; Ctrl+wheel goes nearer"


def words(view: ViewState, sides: CompareSides, reference: str | None, shown: Shown | None) -> str:
    """Return for example "A: diffusion    B: gather"; only A if B is not shown.

    `reference` is the file name of the reference picture, `shown` the picture of side A.
    """
    if shown is None:
        return ""
    a = side_words(shown) if view.depth_of_field else "pinhole"
    if view.compare is Compare.OFF:
        return a
    if view.compare is Compare.GRID:
        return "looks side by side"
    if view.a_look and sides.of_a(view) is not None:
        a = _look_words(view.a_look, sides)
    return f"A: {a}    B: {_b_words(view, sides, reference)}"


def _look_words(name: str, sides: CompareSides) -> str:
    """Return the name of a look, marked as a preview until its whole picture is rendered."""
    return f"look {name}, preview" if sides.is_coming(name) else f"look {name}"


def side_words(shown: Shown) -> str:
    """Return the method and progress of a picture, for example "raytraced, 16 of 256 views"."""
    made, requested = shown.settings, shown.shot.defocus
    if requested.method.needs_scene and made.views < requested.views:
        return f"{requested.method}, {made.views} of {requested.views} views"
    return str(requested.method) if shown.is_whole else f"{requested.method}, preview"


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
    """Draw the text about A and B at the right end of the current line."""
    em = imgui.get_font_size()
    left = imgui.get_window_width() - imgui.calc_text_size(text).x - 0.6 * em
    if text:
        imgui.same_line(left)
        imgui.text_disabled(printable(text))
        probe.note("sides")

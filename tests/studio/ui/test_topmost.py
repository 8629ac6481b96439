"""Escape closes the topmost window or list, and no key reaches those below it."""

from pathlib import Path

from imgui_bundle import imgui

from heatlens.studio.ui import topmost

K = imgui.Key


def is_open() -> bool:
    return imgui.is_popup_open("", imgui.PopupFlags_.any_popup)


def test_f1_and_escape_close_the_keys_window(gui):
    for close in (K.f1, K.escape):
        gui.key(K.f1)
        gui.frame(3)
        assert gui.ui.shows_keys and is_open()
        gui.key(close)
        gui.frame(2)
        assert not gui.ui.shows_keys and not is_open()


def test_shortcuts_do_nothing_while_the_keys_window_is_open(gui):
    gui.key(K.f1)
    gui.frame(3)
    shot, view = gui.session.facts.shot, gui.session.facts.view
    for key in (K.w, K.p, K.e, K.o, K.q, K.right_bracket, K.space):
        gui.key(key)
    assert (gui.session.facts.shot, gui.session.facts.view) == (shot, view)
    gui.key(K.escape)
    gui.frame(2)
    gui.key(K.p)
    assert gui.session.facts.view != view


def test_escape_closes_a_menu_and_a_click_opens_another(gui):
    gui.click(gui.middle("menu File"))
    assert is_open()
    gui.key(K.escape)
    gui.frame(2)
    assert not is_open()
    gui.click(gui.middle("menu View"))
    assert is_open() and "item Depth of field" in gui.drawn
    gui.key(K.escape)
    gui.frame(2)


def test_menus_work_by_keyboard(gui):
    frame, before = gui.session.facts.frame, gui.session.facts.shot
    gui.session.lens.commands.step_f_stop(3)
    gui.rest()
    assert gui.session.facts.shot != before
    for key in (K.f10, K.right_arrow, K.down_arrow, K.up_arrow, K.enter):  # Edit, Undo
        gui.key(key)
        gui.frame(3)
    assert not is_open() and gui.session.facts.frame == frame
    assert gui.session.facts.shot == before


def test_escape_closes_a_list_before_its_dialog(gui):
    gui.session.time.marks.set_here()
    gui.ui.open_pull()
    gui.frame(3)
    gui.click(gui.middle("from"))
    stack = imgui.get_current_context().open_popup_stack
    assert len(stack) == 2
    gui.key(K.escape)
    gui.frame(2)
    assert len(imgui.get_current_context().open_popup_stack) == 1
    gui.key(K.escape)
    gui.frame(2)
    assert not is_open()


def test_pull_box_can_be_canceled(gui):
    gui.session.time.marks.set_here()
    before = gui.session.facts.shot
    gui.ui.open_pull()
    gui.frame(3)
    gui.click(gui.middle("cancel pull"))
    gui.frame(2)
    assert not is_open() and gui.session.facts.shot == before


def dialog_rectangle() -> tuple[float, float, float, float]:
    """Return the rectangle of the dialog on top."""
    stack = imgui.get_current_context().open_popup_stack
    window = stack[len(stack) - 1].window
    return window.pos.x, window.pos.y, window.pos.x + window.size.x, window.pos.y + window.size.y


def drag_beyond_corners(gui, name):
    """Drag a dialog by its title beyond each corner, and check that it stays wholly in view."""
    for corner in ((-900, 3000), (3000, 3000), (-900, 1), (3000, 1)):
        x0, y0, _, _ = dialog_rectangle()
        gui.drag((x0 + 60, y0 + 8), corner)
        gui.frame(2)
        x0, y0, x1, y1 = dialog_rectangle()
        bar = imgui.get_main_viewport().work_pos.y
        assert x0 >= 0 and y0 >= bar and x1 <= gui.size[0] and y1 <= gui.size[1], (name, corner)


def test_dialog_cannot_be_dragged_out_of_view(gui):
    gui.do("Open...")
    gui.frame(3)
    drag_beyond_corners(gui, "the browser")
    gui.key(K.escape)
    gui.frame(2)


def test_modal_dialogs_are_begun_only_in_topmost():
    """Only `topmost.py`, which moves a dialog into view, begins modal dialogs."""
    folder = Path(topmost.__file__).parent
    file_names = [
        path.name for path in folder.rglob("*.py") if "begin_popup_modal" in path.read_text()
    ]
    assert file_names == ["topmost.py"]

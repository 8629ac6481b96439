"""Escape closes what lies on top, and no key reaches what lies under it."""

from imgui_bundle import imgui

K = imgui.Key


def is_open() -> bool:
    return imgui.is_popup_open("", imgui.PopupFlags_.any_popup)


def test_question_mark_and_escape_close_the_keys(gui):
    for close, shift in ((K.slash, True), (K.escape, False)):
        gui.key(K.slash, shift=True)
        gui.frame(3)
        assert gui.ui.shows_keys and is_open()
        gui.key(close, shift=shift)
        gui.frame(2)
        assert not gui.ui.shows_keys and not is_open()


def test_keys_behind_the_keys_window_do_nothing(gui):
    gui.key(K.slash, shift=True)
    gui.frame(3)
    shot, view = gui.session.facts.shot, gui.session.facts.view
    for key in (K.w, K.p, K.e, K.o, K.q, K.right_bracket, K.space):
        gui.key(key)
    assert (gui.session.facts.shot, gui.session.facts.view) == (shot, view)
    gui.key(K.escape)
    gui.frame(2)
    gui.key(K.p)
    assert gui.session.facts.view != view


def test_escape_closes_a_menu_then_the_next_click_opens_another(gui):
    gui.click(gui.middle("menu File"))
    assert is_open()
    gui.key(K.escape)
    gui.frame(2)
    assert not is_open()
    gui.click(gui.middle("menu View"))
    assert is_open() and "item Fit" in gui.drawn
    gui.key(K.escape)
    gui.frame(2)


def test_the_menus_can_be_gone_through_by_keyboard(gui):
    frame, before = gui.session.facts.frame, gui.session.facts.shot
    gui.session.lens.commands.step_f_stop(3)
    gui.rest()
    assert gui.session.facts.shot != before
    for key in (K.f10, K.right_arrow, K.down_arrow, K.up_arrow, K.enter):  # Edit, Undo
        gui.key(key)
        gui.frame(3)
    assert not is_open() and gui.session.facts.frame == frame
    assert gui.session.facts.shot == before


def test_a_list_in_a_dialog_closes_before_the_dialog(gui):
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


def test_a_pull_can_be_cancelled(gui):
    gui.session.time.marks.set_here()
    before = gui.session.facts.shot
    gui.ui.open_pull()
    gui.frame(3)
    gui.click(gui.middle("cancel pull"))
    gui.frame(2)
    assert not is_open() and gui.session.facts.shot == before

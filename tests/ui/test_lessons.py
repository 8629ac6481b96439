"""What comes with heatlens teaches three gestures; a line goes once its gesture was done."""

from collections.abc import Iterator

import pytest
from imgui_bundle import imgui

from heatlens.paths import data_dir
from heatlens.session.lessons import Lesson, Lessons
from support.gui import Gui, gui_of
from support.window_plates import QUICK, room_file

K = imgui.Key


@pytest.fixture(scope="module")
def still(session_context) -> Iterator[Gui]:
    with gui_of(session_context, data_dir("assets") / "still_life.exr", defocus=QUICK) as gui:
        yield gui


@pytest.fixture
def gui(ctx, still) -> Gui:
    still.begin_again()
    still.screen.picture._lessons = Lessons(still.session.editing, still.session.marks)
    still.frame(3)
    return still


def left(gui) -> tuple[Lesson, ...]:
    return gui.screen.picture._lessons.left


def test_each_gesture_is_ticked_off_as_it_is_done(gui):
    assert left(gui) == tuple(Lesson)
    gui.click(gui.at_picture(100, 60))
    assert left(gui) == (Lesson.DRAG, Lesson.PULL)
    x0, y0, x1, y1 = gui.rect("focus bar")
    gui.drag((x0 + 20, (y0 + y1) / 2), (x1 - 60, (y0 + y1) / 2))
    assert left(gui) == (Lesson.PULL,)
    gui.key(K.m)
    gui.click(gui.at_picture(300, 200))
    gui.key(K.m, shift=True)
    gui.key(K.enter)
    gui.frame(2)
    assert left(gui) == ()


def test_a_legend_stands_beside_the_lessons_and_in_their_place_once_they_are_gone(gui):
    gui.key(K.z)
    gui.frame(2)
    lessons = imgui.internal.find_window_by_name("lessons")
    assert gui.rect("legend")[0] > lessons.pos.x + lessons.size.x
    gui.click(gui.middle("dismiss lessons"))
    gui.frame(2)
    assert gui.rect("legend")[0] < lessons.pos.x + lessons.size.x
    gui.key(K.z)


def test_whoever_knows_them_sends_them_away(gui):
    gui.click(gui.middle("dismiss lessons"))
    assert left(gui) == ()


def test_a_file_of_ones_own_teaches_nothing(gui, tmp_path):
    gui.open(room_file(tmp_path / "room.exr"))
    assert left(gui) == ()

"""The lessons on the demo pictures teach three gestures; each line goes once it is done."""

from collections.abc import Iterator

import pytest
from imgui_bundle import imgui

from heatlens.core.base.paths import data_dir
from heatlens.core.model.shot.lens_parameter import LensParameter
from heatlens.studio.board.lessons import Lesson, Lessons
from support.gui import Gui, gui_of
from support.session_files import QUICK, room_file

K = imgui.Key
FOCUS = LensParameter.FOCUS_DISTANCE


@pytest.fixture(scope="module")
def still(session_context) -> Iterator[Gui]:
    with gui_of(session_context, data_dir("assets") / "still_life.exr", defocus=QUICK) as gui:
        yield gui


@pytest.fixture
def gui(ctx, still) -> Gui:
    still.begin_again()
    still.screen.picture._lessons = Lessons(still.session.editing, still.session.time.marks)
    still.frame(3)
    return still


def remaining_lessons(gui) -> tuple[Lesson, ...]:
    return gui.screen.picture._lessons.remaining


def test_each_lesson_disappears_when_its_gesture_is_done(gui):
    assert remaining_lessons(gui) == tuple(Lesson)
    gui.click(gui.at_picture(100, 60))
    assert remaining_lessons(gui) == (Lesson.DRAG, Lesson.PULL)
    x0, y0, x1, y1 = gui.rect("focus bar")
    gui.drag((x0 + 20, (y0 + y1) / 2), (x1 - 60, (y0 + y1) / 2))
    assert remaining_lessons(gui) == (Lesson.PULL,)
    gui.key(K.m)
    gui.click(gui.at_picture(300, 200))
    gui.key(K.m, shift=True)
    gui.key(K.enter)
    gui.frame(2)
    assert remaining_lessons(gui) == ()


def test_legend_stands_beside_the_lessons_or_in_their_place(gui):
    gui.key(K.z)
    gui.frame(2)
    lessons = imgui.internal.find_window_by_name("lessons")
    assert gui.rect("legend")[0] > lessons.pos.x + lessons.size.x
    gui.click(gui.middle("dismiss lessons"))
    gui.frame(2)
    assert gui.rect("legend")[0] < lessons.pos.x + lessons.size.x
    gui.key(K.z)


@pytest.mark.parametrize(("scale", "has_all"), [(1.0, True), (1.5, False), (2.0, False)])
def test_lessons_cover_at_most_a_quarter_of_the_picture(gui, scale, has_all):
    shot = gui.session.facts.shot.with_key(1, FOCUS, 1.0).with_key(9, FOCUS, 2.0)  # with a timeline
    gui.session.editing.begin(shot)
    gui.session.preferences.change(ui_scales={"": scale})
    gui.frame(6)
    gui.drawn.clear()
    gui.frame(2)
    lessons, picture = map(imgui.internal.find_window_by_name, ("lessons", "Picture"))
    assert lessons.active and lessons.size.y <= 0.25 * picture.size.y
    assert lessons.pos.x + lessons.size.x <= picture.pos.x + picture.size.x
    assert ("lesson PULL" in gui.drawn) == has_all and "lesson CLICK" in gui.drawn
    hide, words = gui.rect("dismiss lessons"), gui.rect("lesson CLICK")
    assert words[2] <= hide[0] and hide[2] <= lessons.pos.x + lessons.size.x
    gui.session.preferences.change(ui_scales={})
    gui.frame(4)


def test_files_of_the_demo_are_saved_to_the_users_pictures_folder(gui, monkeypatch, tmp_path):
    monkeypatch.setenv("XDG_PICTURES_DIR", str(tmp_path))
    files = gui.session.files.commands
    for key in ("save shot", "sheet", "save"):
        assert files.first_folder(key) == tmp_path, key
    assert files.first_folder("open") == data_dir("assets")


def test_lessons_can_be_dismissed(gui):
    gui.click(gui.middle("dismiss lessons"))
    assert remaining_lessons(gui) == ()


def test_lessons_leave_the_place_to_a_dialog(gui):
    for is_open in (False, True):
        if is_open:
            gui.key(K.o, ctrl=True)
        gui.drawn.clear()
        gui.frame(3)
        assert ("lesson CLICK" in gui.drawn) != is_open
    gui.key(K.escape)
    gui.frame(3)
    assert "lesson CLICK" in gui.drawn


def test_users_own_file_has_no_lessons(gui, tmp_path):
    gui.open(room_file(tmp_path / "room.exr"))
    assert remaining_lessons(gui) == ()

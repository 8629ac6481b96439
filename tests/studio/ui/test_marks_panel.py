"""Focus marks in the window: set, named, focused, pulled to and followed; one undo step each."""

from dataclasses import replace

import numpy as np
import pytest
from imgui_bundle import imgui

from heatlens.core.model.marks.marks import DistanceMark, MatteMark, MattePart, WorldMark
from heatlens.core.model.marks.track_mark import Click
from heatlens.core.model.shot.pull import pull
from support.cards import FOCAL_PX
from support.cards import POST as CARD
from support.dolly_plates import STEP_M, write_dolly
from support.gui import Gui, gui_of
from support.sequences import FIRST, LAST, relative_distance
from support.session_files import BALL, BALL_M, POST, POST_M, QUICK
from support.timeline_window import reset_window, type_into

K = imgui.Key


@pytest.fixture
def gui(ctx, film) -> Gui:
    gui = reset_window(film)
    imgui.set_window_focus("Marks")
    gui.frame(2)
    return gui


def marks(gui) -> tuple:
    return gui.session.facts.shot.marks


def ctrl_shift_click(gui, pixel: tuple[int, int]) -> None:
    """Set a mark with Ctrl+Shift+click on a pixel."""
    gui.frame(30)
    for mod in (K.mod_ctrl, K.mod_shift):
        gui.hold(mod)
    gui.click(gui.at_picture(pixel[0] + 0.5, pixel[1] + 0.5))
    for mod in (K.mod_ctrl, K.mod_shift):
        gui.hold(mod, down=False)
    gui.until(lambda: not gui.session.time.marks.anchors.tracking.is_busy, "its surface")


def test_m_key_marks_the_distance_in_focus(gui):
    gui.session.editing.edit_lens(replace(gui.session.facts.lens, focus_distance_m=3.5))
    gui.rest()
    gui.key(K.m)
    gui.key(K.m)
    assert marks(gui) == (DistanceMark("A", 3.5), DistanceMark("B", 3.5))
    assert gui.undo_count() == 3


def test_new_mark_is_reported_and_drawn_on_the_focus_bar(gui):
    gui.key(K.m)
    assert gui.session.messages.text.startswith("Mark A is set")
    gui.session.lens.commands.focus(10.0)
    gui.key(K.m)
    imgui.set_window_focus("Lens")
    gui.frame(3)
    (x0, y0, x1, y1), first, second = (
        gui.rect(name) for name in ("focus bar", "A on the bar", "B on the bar")
    )
    assert x0 <= first[0] and first[2] < second[0] and second[2] <= x1
    assert y0 <= first[1] and first[3] < y1


def test_names_of_near_marks_do_not_overlap_on_the_focus_bar(gui):
    for _ in range(3):
        gui.key(K.m)  # all at one distance
    gui.drawn.clear()
    imgui.set_window_focus("Lens")
    gui.frame(3)
    (_, _, _, low), (_, high, _, _) = gui.rect("A on the bar"), gui.rect("B on the bar")
    assert low <= high and "C on the bar" not in gui.drawn  # two rows


def test_ctrl_shift_click_marks_the_surface_there_and_keeps_the_focus(gui):
    before = gui.session.facts.lens
    ctrl_shift_click(gui, BALL)
    (mark,) = marks(gui)
    assert mark.name == "A" and mark.clicks == (Click(FIRST, float(BALL[0]), float(BALL[1])),)
    assert gui.session.facts.lens == before and gui.undo_count() == 1
    x, y, _, _ = gui.rect("point A")
    assert (x, y) == pytest.approx(gui.at_picture(BALL[0] + 0.5, BALL[1] + 0.5))


def test_go_to_point_mark_focuses_at_its_distance_of_the_frame(gui):
    ctrl_shift_click(gui, BALL)
    for number in (FIRST, 1005, LAST):
        gui.session.time.timeline.go_to(number)
        gui.until(lambda n=number: gui.session.pictures.live.output.frame == n, "the picture")
        gui.click(gui.middle("go A"))
        assert gui.session.facts.lens.focus_distance_m == pytest.approx(
            BALL_M * relative_distance(number), rel=1e-5
        )
        gui.frame(30)


def test_mark_is_renamed_but_not_to_a_name_in_use(gui):
    gui.key(K.m)
    gui.key(K.m)
    gui.frame(2)
    type_into(gui, "mark A", "actor")
    assert [mark.name for mark in marks(gui)] == ["actor", "B"]
    type_into(gui, "mark B", "actor")
    assert [mark.name for mark in marks(gui)] == ["actor", "B"]
    assert "Two marks are called actor" in gui.session.messages.text


def test_deleted_mark_comes_back_by_undo(gui):
    gui.key(K.m)
    gui.frame(2)
    gui.click(gui.middle("delete A"))
    assert marks(gui) == ()
    gui.key(K.z, ctrl=True)
    assert [mark.name for mark in marks(gui)] == ["A"]


def make_pull(gui, frames: str) -> None:
    """Pull the focus: Shift+M, type the number of frames, Enter."""
    gui.key(K.m, shift=True)
    gui.frame(3)
    gui.key(K.a, ctrl=True)
    gui.type(frames)
    gui.key(K.enter)
    gui.frame(3)


def test_pull_by_shift_m_sets_two_keys_in_one_undo_step(gui):
    gui.session.editing.edit_lens(replace(gui.session.facts.lens, focus_distance_m=4.0))
    gui.rest()
    ctrl_shift_click(gui, POST)
    gui.session.time.timeline.go_to(1002)
    before = gui.session.facts.shot
    make_pull(gui, "5")
    to_m = POST_M * relative_distance(1007)  # where it is when the focus arrives
    keys = gui.session.facts.shot.curves.focus_distance_m.keys
    assert [key.frame for key in keys] == [1002, 1007]
    assert keys[1].value == pytest.approx(to_m, rel=1e-5)
    assert gui.session.facts.shot == pull(before, 4.0, keys[1].value, 1002, 5)
    assert gui.undo_count() == 3
    assert not imgui.is_popup_open("", imgui.PopupFlags_.any_popup)
    gui.key(K.z, ctrl=True)
    assert gui.session.facts.shot == before


def test_pull_box_pulls_from_mark_to_mark_by_mouse(gui):
    ctrl_shift_click(gui, BALL)
    ctrl_shift_click(gui, POST)
    gui.click(gui.middle("open pull"))
    gui.frame(3)
    gui.click(gui.middle("from"))
    gui.click(gui.middle("from: A"))
    gui.frame(2)
    gui.click(gui.middle("to mark"))
    gui.click(gui.middle("to mark: B"))
    gui.frame(2)
    gui.click(gui.middle("pull"))
    keys = gui.session.facts.shot.curves.focus_distance_m.keys
    assert [key.frame for key in keys] == [FIRST, LAST]  # there are fewer than 18
    assert keys[0].value == pytest.approx(BALL_M)
    assert keys[1].value == pytest.approx(POST_M * relative_distance(LAST))
    assert gui.session.messages.text.startswith("B holds on")  # and nothing about the pull


def test_pull_box_shift_enter_goes_to_the_end_for_the_next_pull(gui):
    """Shift+Enter makes the pull and moves the playhead to its end, where the next one begins."""
    ctrl_shift_click(gui, BALL)
    ctrl_shift_click(gui, POST)
    gui.session.time.marks.focus_on(gui.session.facts.shot.marks[0])
    gui.session.time.marks.pulls.set_length(2)
    for shift in (True, False):
        gui.key(K.m, shift=True)
        gui.frame(3)
        gui.key(K.enter, shift=shift)
        gui.frame(3)
        assert not imgui.is_popup_open("", imgui.PopupFlags_.any_popup)
    keys = gui.session.facts.shot.curves.focus_distance_m.keys
    assert [key.frame for key in keys] == [FIRST, FIRST + 2, FIRST + 4]
    assert gui.session.facts.frame == FIRST + 2
    assert keys[2].value == pytest.approx(BALL_M * relative_distance(FIRST + 4))


def test_mark_on_a_place_is_drawn_where_the_camera_sees_it_and_its_flag_tells_so(ctx, tmp_path):
    with gui_of(ctx, write_dolly(tmp_path), defocus=QUICK) as gui:
        clicked = 36, 24
        ctrl_shift_click(gui, clicked)
        assert isinstance(marks(gui)[0], WorldMark)
        for frame in (1, 3):  # the camera has moved to the right by two steps, and the post so left
            gui.session.time.timeline.go_to(frame)
            gui.until(lambda it=frame: gui.session.source.is_settled_at(it), "it")
            gui.frame(3)
            shift_px = FOCAL_PX * STEP_M * (frame - 1) / CARD.z
            expected = gui.at_picture(clicked[0] + 0.5 - shift_px, clicked[1] + 0.5)
            assert gui.rect("point A")[:2] == pytest.approx(expected, abs=0.5)
        gui.move(gui.middle("A on the bar"))
        gui.frame(2)
        x0, _, x1, _ = gui.rect("distance at the pointer")
        assert x1 - x0 == pytest.approx(imgui.calc_text_size("A, the place: 2 m").x)
        assert "place of the mark" in gui.drawn  # the loupe


def test_shift_m_without_a_mark_only_reports(gui):
    gui.key(K.m, shift=True)
    gui.frame(3)
    assert "Set a mark" in gui.session.messages.text
    assert not imgui.is_popup_open("", imgui.PopupFlags_.any_popup)


def test_follow_button_sets_focus_keys_for_all_frames(gui):
    ctrl_shift_click(gui, BALL)
    gui.click(gui.middle("follow A"))
    gui.until(lambda: gui.session.facts.shot.key_frames, "the keys")
    keys = gui.session.facts.shot.curves.focus_distance_m.keys
    assert (keys[0].frame, keys[-1].frame) == (FIRST, LAST)
    for key in keys:
        assert key.value == pytest.approx(BALL_M * relative_distance(int(key.frame)), rel=5e-3)
    assert gui.undo_count() == 2


def test_mark_that_is_tracked_can_be_stopped_in_its_row_and_in_the_status_bar(gui, monkeypatch):
    ctrl_shift_click(gui, POST)
    (mark,), tracking = marks(gui), gui.session.time.marks.anchors.tracking
    monkeypatch.setattr(tracking, "_begin", lambda: None)  # it waits for the thread
    for button in (f"stop {mark.name}", "status Stop"):
        tracking.start(mark, mark, lambda *_: None)
        gui.drawn.clear()
        gui.frame(2)
        assert f"follow {mark.name}" not in gui.drawn
        gui.click(gui.middle(button))
        assert not tracking.is_busy and f"follow {mark.name}" in gui.drawn
    assert "stays on the surface" in gui.session.messages.text


def test_lit_matte_tints_its_part_of_the_picture_alone(gui, monkeypatch):
    gui.settled()
    gui.move(gui.middle("focus bar"))
    gui.frame(2)
    before = gui.screenshot().astype(int)
    window = gui.session.facts.plate.data_window
    coverage = np.zeros(window.shape, np.float32)
    coverage[:, : window.width // 2] = 1.0
    light = gui.session.time.marks.light
    monkeypatch.setattr(type(light), "matte", (coverage, window))
    gui.frame(2)
    x0, y0, x1, y1 = (round(value) for value in gui.rect("lit matte"))
    change = (gui.screenshot().astype(int) - before)[y0 + 4 : y1 - 4]
    assert change[:, x0 + 4 : (x0 + x1) // 2 - 8].any(-1).mean() > 0.9
    assert not change[:, (x0 + x1) // 2 + 8 : x1].any()


def test_live_button_follows_until_make_keys_or_let_go(gui):
    ctrl_shift_click(gui, BALL)

    def live():
        return gui.session.facts.shot.curves.live

    gui.click(gui.middle("hold A"))
    gui.frame(2)
    gui.click(gui.middle("live A"))
    gui.until(lambda: live().measured, "the distances")
    for frame in (FIRST, LAST):
        focus_m = gui.session.facts.shot.lens_at(frame).focus_distance_m
        assert focus_m == pytest.approx(BALL_M * relative_distance(frame), rel=5e-2)
    assert gui.undo_count() == 2 and not gui.session.facts.shot.key_frames
    gui.frame(2)
    _, y0, x1, y1 = gui.rect("follow ease")
    gui.click((x1 - 2, (y0 + y1) / 2))
    assert live().follow.ease_frames >= 20
    gui.rest()
    gui.session.editing.undo()
    gui.frame(2)
    gui.click(gui.middle("make keys"))
    assert live() is None and gui.session.facts.shot.key_frames
    gui.session.editing.undo()
    gui.frame(2)
    gui.click(gui.middle("stop following"))
    assert live() is None and not gui.session.facts.shot.key_frames
    assert gui.undo_count() == 3


def test_close_focus_field_takes_distances_only(gui):
    type_into(gui, "close focus", "90cm")
    assert gui.session.facts.lens.close_focus_m == 0.9
    type_into(gui, "close focus", "soon")
    assert gui.session.facts.lens.close_focus_m == 0.9 and "soon" in gui.session.messages.text


def test_matte_mark_button_toggles_middle_and_nearest_part(gui):
    editing = gui.session.editing
    editing.do(replace(editing.shot, marks=(MatteMark("A", "cryptomatte:hero"),)))
    gui.frame(2)
    gui.click(gui.middle("part A"))
    assert marks(gui) == (MatteMark("A", "cryptomatte:hero", MattePart.NEAREST),)
    gui.click(gui.middle("part A"))
    assert marks(gui)[0].part is MattePart.MIDDLE

"""A focus pull by hand: recorded while the shot plays, and stretched by its end."""

import pytest
from imgui_bundle import imgui

from heatlens.core.model.keys.key_choice import all_keys
from heatlens.core.model.shot.lens_parameter import LensParameter
from heatlens.core.model.shot.pull import PullShape, RecordingState, shaped_pull
from support.gui import Gui
from support.sequences import FIRST, LAST
from support.timeline_window import reset_window, ruler_position

K = imgui.Key
FOCUS = LensParameter.FOCUS_DISTANCE


@pytest.fixture
def gui(ctx, film) -> Gui:
    return reset_window(film)


def focus_key_frames(gui) -> list[float]:
    return [key.frame for key in gui.session.facts.shot.curves.focus_distance_m.keys]


def focus_m(gui, frame: int) -> float:
    return gui.session.facts.shot.lens_at(frame).focus_distance_m


def perform(gui) -> None:
    """Press record and Space, and drag along the focus bar while the frames are played."""
    gui.click(gui.middle("transport record"))
    assert gui.session.time.recording.state is RecordingState.ARMED
    gui.key(K.space)
    x0, y0, x1, y1 = gui.rect("focus bar")
    gui.press((x0 + 0.3 * (x1 - x0), (y0 + y1) / 2))
    for frame in range(FIRST, LAST + 1):
        gui.session.time.timeline.move_playhead(frame)
        gui.move((x0 + (0.3 + 0.05 * (frame - FIRST)) * (x1 - x0), (y0 + y1) / 2))


def test_pull_is_recorded_by_a_drag_of_the_focus_bar(gui):
    before = gui.session.editing.history.end_gesture()
    perform(gui)
    assert (
        gui.session.time.recording.state is RecordingState.RECORDING and focus_key_frames(gui) == []
    )
    gui.key(K.space)
    gui.release()
    assert gui.session.time.recording.state is RecordingState.RECORDED
    assert focus_key_frames(gui)[0] in (FIRST, FIRST + 1) and focus_key_frames(gui)[-1] == LAST
    assert gui.session.editing.history.past == (*before.past, before.current)
    key_count = len(focus_key_frames(gui))
    x0, y0, x1, y1 = gui.rect("tolerance")
    gui.drag((x0 + 5, (y0 + y1) / 2), (x1 - 5, (y0 + y1) / 2))
    assert len(focus_key_frames(gui)) <= key_count
    gui.click(gui.middle("recording Keep"))
    assert gui.session.time.recording.state is RecordingState.OFF and focus_key_frames(gui)
    gui.key(K.z, ctrl=True)
    assert focus_key_frames(gui) == []


def test_count_in_is_shown_over_the_picture(gui, monkeypatch):
    clock_s = 50.0
    recording = gui.session.time.recording
    monkeypatch.setattr(recording, "_clock", lambda: clock_s)
    recording.beats = 3
    gui.click(gui.middle("transport record"))
    gui.key(K.space)
    for number in (3, 2, 1):
        gui.drawn.clear()
        gui.frame(2)
        assert f"beat {number}" in gui.drawn and recording.state is RecordingState.COUNTING
        clock_s += 1.0
    gui.drawn.clear()
    gui.frame(2)
    assert recording.state is RecordingState.RECORDING
    assert not [name for name in gui.drawn if name.startswith("beat")]
    gui.key(K.escape)


@pytest.mark.parametrize("is_over", [False, True])
def test_escape_drops_a_recording(gui, is_over):
    perform(gui)
    if is_over:
        gui.key(K.space)
    gui.key(K.escape)
    gui.release()
    assert focus_key_frames(gui) == [] and gui.session.time.recording.state is RecordingState.OFF
    assert not gui.session.time.timeline.playback.direction


@pytest.mark.parametrize("shape", [shape for shape in PullShape if shape != PullShape.EASE])
def test_pull_box_makes_a_pull_of_the_chosen_shape(gui, shape):
    marks = gui.session.time.marks
    marks.set_here()
    gui.session.lens.commands.focus(4.0)
    gui.rest()
    before, target_m = gui.session.facts.shot, gui.session.facts.shot.marks[0].distance_m
    gui.key(K.m, shift=True)
    gui.frame(3)
    x0, _, x1, _ = gui.rect("pull on the bar")  # from the needle to the flag of the mark
    needle_x, _ = gui.middle("focus on the bar")
    flag_x0, _, flag_x1, _ = gui.rect("A on the bar")
    assert min(abs(x0 - needle_x), abs(x1 - needle_x)) < 1.0
    assert any(abs(x - flag_x) < 1.0 for x in (x0, x1) for flag_x in (flag_x0, flag_x1))
    gui.click(gui.middle("shape"))
    gui.click(gui.middle(f"shape: {shape}"))
    gui.frame(2)
    gui.click(gui.middle("pull"))
    marks.pulls.shape = PullShape.EASE
    frames = LAST - FIRST  # there are fewer than a pull has otherwise
    assert gui.session.facts.shot == shaped_pull(before, 4.0, target_m, FIRST, frames, shape)
    assert gui.session.facts.shot != shaped_pull(before, 4.0, target_m, FIRST, frames)


def test_reverse_action_and_hold_key_change_a_pull(gui):
    shot = gui.session.facts.shot.with_key(1002, FOCUS, 1.5).with_key(1005, FOCUS, 3.0)
    gui.session.editing.begin(shot)
    gui.do("Reverse the pull")
    assert [focus_m(gui, frame) for frame in (1002, 1005)] == [3.0, 1.5]
    gui.session.time.timeline.go_to(1003)
    gui.frame(2)
    held_m = gui.session.facts.lens.focus_distance_m
    assert focus_m(gui, 1004) != held_m
    gui.key(K.h)
    assert [focus_m(gui, frame) for frame in (1003, 1004, 1005)] == [held_m, held_m, 1.5]


@pytest.mark.parametrize("as_curve", [False, True])
def test_stretch_grip_lengthens_a_pull_in_one_undo_step(gui, as_curve):
    shot = gui.session.facts.shot
    for frame, distance_m in ((1002, 1.5), (1003, 2.5), (1004, 2.0)):
        shot = shot.with_key(frame, FOCUS, distance_m)
    gui.session.editing.begin(shot)
    gui.session.time.keys.rows.shows_curve = as_curve
    gui.frame(2)
    assert "stretch last" not in gui.drawn or not gui.session.time.keys.selection
    gui.session.time.keys.select(all_keys(shot))
    gui.frame(2)
    x, y = gui.middle("stretch last")
    gui.drag((x, y), (x + ruler_position(gui, 1006)[0] - ruler_position(gui, 1004)[0], y))
    assert focus_key_frames(gui) == [1002, 1004, 1006]
    gui.rest()
    assert len(gui.session.editing.history.past) == 1
    x, y = gui.middle("stretch first")
    gui.drag((x, y), (x + ruler_position(gui, 1009)[0] - ruler_position(gui, 1002)[0], y))
    assert focus_key_frames(gui)[-1] == 1006 and len(focus_key_frames(gui)) == 3

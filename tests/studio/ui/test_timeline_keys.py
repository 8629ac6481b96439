"""Keys by mouse and keyboard: set, chosen, dragged, copied, eased; a gesture is one step."""

from collections.abc import Iterator
from dataclasses import replace

import pytest
from imgui_bundle import imgui

from heatlens.core.model.curves.interpolation import Interpolation
from heatlens.core.model.shot.lens_parameter import LensParameter
from heatlens.studio.session.keys.key_choice import KeyId
from support.gui import Gui
from support.sequences import FIRST, LAST
from support.timeline_window import at_frame, film_window, frame, fresh

K = imgui.Key
FOCUS, F_STOP = LensParameter.FOCUS_DISTANCE, LensParameter.F_STOP
KEYED = {1002: 1.5, 1004: 3.0, 1007: 2.0}  # focus distances in metres by frame


@pytest.fixture(scope="module")
def film(session_context, tmp_path_factory) -> Iterator[Gui]:
    with film_window(session_context, tmp_path_factory.mktemp("film")) as gui:
        yield gui


@pytest.fixture
def gui(ctx, film) -> Gui:
    return fresh(film)


@pytest.fixture
def keyed(gui) -> Gui:
    """Set three keys of the focus and one of the f-stop."""
    shot = gui.session.facts.shot
    for number, distance_m in KEYED.items():
        shot = shot.with_key(number, FOCUS, distance_m)
    gui.session.editing.begin(shot.with_key(1004, F_STOP, 2.0))
    gui.frame(2)
    return gui


def focus_keys(gui) -> dict[float, float]:
    return {key.frame: key.value for key in gui.session.facts.shot.curves.focus_distance_m.keys}


def f_stop_frames(gui) -> list[float]:
    return [key.frame for key in gui.session.facts.shot.curves.f_stop.keys]


def steps(gui) -> int:
    gui.rest()
    return len(gui.session.editing.history.past)


def place(gui, number: int, parameter=FOCUS) -> tuple[float, float]:
    x, y, _, _ = gui.rect(f"key {parameter} {number}")
    return x, y


def drag_key(gui, number: int, to: int, parameter=FOCUS, through: tuple[int, ...] = ()) -> None:
    """Drag a key's diamond to a frame."""
    start = place(gui, number, parameter)
    gui.press(start)
    for column in (*through, to):
        gui.move((at_frame(gui, column)[0], start[1] + 1))
    gui.release()


def test_k_keys_whatever_has_keys(keyed):
    keyed.session.time.timeline.go(1006)
    value = keyed.session.facts.lens.focus_distance_m
    keyed.key(K.k)
    assert focus_keys(keyed) == KEYED | {1006: value}
    assert f_stop_frames(keyed) == [1004, 1006] and steps(keyed) == 1


def test_a_click_in_the_picture_makes_a_key_where_there_are_keys(keyed):
    keyed.session.time.timeline.go(1005)
    keyed.frame(2)
    keyed.click(keyed.at_picture(60.5, 32.5))
    assert list(focus_keys(keyed)) == [1002, 1004, 1005, 1007]
    keyed.key(K.a)
    keyed.session.time.timeline.go(1006)
    keyed.frame(2)
    before = keyed.session.facts.shot
    keyed.click(keyed.at_picture(22.5, 50.5))
    assert keyed.session.facts.shot == before and "auto key" in keyed.session.messages.text


def test_a_dragged_key_is_one_step_and_gives_back_what_it_passed(keyed):
    drag_key(keyed, 1002, 1005, through=(1003, 1004))
    assert focus_keys(keyed) == {1004: 3.0, 1005: 1.5, 1007: 2.0}
    assert steps(keyed) == 1
    assert keyed.session.time.keys.chosen == {KeyId(FOCUS, 1005)}
    keyed.key(K.z, ctrl=True)
    assert focus_keys(keyed) == KEYED


def test_shift_gathers_keys_and_they_move_together(keyed):
    keyed.click(place(keyed, 1002))
    keyed.hold(K.mod_shift)
    keyed.click(place(keyed, 1004, F_STOP))
    keyed.hold(K.mod_shift, False)
    keyed.frame(30)
    drag_key(keyed, 1004, 1005, F_STOP)
    assert focus_keys(keyed) == {1003: 1.5, 1004: 3.0, 1007: 2.0}
    assert f_stop_frames(keyed) == [1005] and steps(keyed) == 1


def test_a_box_gathers_what_is_in_it_and_a_click_beside_lets_go(keyed):
    x0 = at_frame(keyed, 1003)[0]
    x1 = at_frame(keyed, 1008)[0]
    y = place(keyed, 1004)[1]
    keyed.drag((x0, y - 8), (x1, y + 8))
    assert keyed.session.time.keys.chosen == {KeyId(FOCUS, 1004), KeyId(FOCUS, 1007)}
    keyed.frame(30)
    keyed.key(K.delete)
    assert focus_keys(keyed) == {1002: 1.5} and steps(keyed) == 1
    keyed.click((x1, y))
    assert not keyed.session.time.keys.chosen


def test_ctrl_pushes_all_later_keys_along(keyed):
    keyed.hold(K.mod_ctrl)
    drag_key(keyed, 1004, 1005)
    keyed.hold(K.mod_ctrl, False)
    assert focus_keys(keyed) == {1002: 1.5, 1005: 3.0, 1008: 2.0}
    assert f_stop_frames(keyed) == [1005] and steps(keyed) == 1


def test_keys_are_copied_to_where_the_playhead_is(keyed):
    keyed.click(place(keyed, 1002))
    keyed.hold(K.mod_shift)
    keyed.click(place(keyed, 1004))
    keyed.hold(K.mod_shift, False)
    keyed.key(K.c, ctrl=True, shift=True)
    keyed.session.time.timeline.go(1006)
    keyed.key(K.v, ctrl=True, shift=True)
    assert focus_keys(keyed) == KEYED | {1006: 1.5, LAST: 3.0}
    assert keyed.session.time.keys.chosen == {KeyId(FOCUS, 1006), KeyId(FOCUS, 1008)}
    assert steps(keyed) == 1


def test_keys_move_a_frame_by_key(keyed):
    keyed.do("Select all keys")
    keyed.key(K.right_arrow, ctrl=True, shift=True)
    assert list(focus_keys(keyed)) == [1003, 1005, 1008] and f_stop_frames(keyed) == [1005]
    keyed.key(K.left_arrow, ctrl=True, shift=True)
    assert focus_keys(keyed) == KEYED and frame(keyed) == FIRST


@pytest.mark.parametrize("interpolation", list(Interpolation))
def test_what_follows_a_key_is_chosen_from_a_list(keyed, interpolation):
    keyed.click(place(keyed, 1002))
    keyed.frame(30)
    keyed.click(keyed.middle("interpolation"))
    keyed.click(keyed.middle(f"interpolation: {interpolation}"))
    found = keyed.session.facts.shot.curves.focus_distance_m.keys
    assert [key.interpolation for key in found] == [interpolation, "smooth", "smooth"]


def test_an_ease_is_dragged_as_one_step_and_makes_a_bezier(keyed):
    keyed.click(place(keyed, 1002))
    keyed.frame(30)
    at = keyed.middle("ease out")
    keyed.drag(at, (at[0] + 30, at[1]))
    first = keyed.session.facts.shot.curves.focus_distance_m.keys[0]
    assert first.interpolation is Interpolation.BEZIER
    assert first.ease_out.influence_percent > 100 / 3 and steps(keyed) == 1


def test_up_and_down_go_from_key_to_key(keyed):
    visited = []
    for _ in range(4):
        keyed.key(K.down_arrow)
        visited.append(frame(keyed))
    keyed.key(K.up_arrow)
    assert visited == [1002, 1004, 1007, 1007] and frame(keyed) == 1004


def test_the_dot_before_a_row_sets_a_key_and_takes_it_away(gui):
    gui.click(gui.middle("dot f_stop"))
    assert f_stop_frames(gui) == [FIRST]
    gui.frame(30)
    gui.click(gui.middle("dot f_stop"))
    assert f_stop_frames(gui) == []


def test_the_dot_before_a_control_of_the_lens_does_the_same(gui):
    gui.click(gui.middle(f"lens dot {FOCUS}"))
    assert list(focus_keys(gui)) == [FIRST] and steps(gui) == 1


def test_a_frame_at_which_no_lens_can_be_is_said_and_the_picture_stays(gui):
    """Both keys have a lens: focus is held near while the focal length grows beyond it."""
    shot = gui.session.facts.shot
    for number, distance_m, focal_mm in ((1002, 0.3, 100.0), (1007, 5.0, 800.0)):
        shot = shot.with_key(number, FOCUS, distance_m)
        shot = shot.with_key(number, LensParameter.FOCAL_LENGTH, focal_mm)
    curve = shot.curves.focus_distance_m
    held = replace(curve.keys[0], interpolation=Interpolation.HOLD)
    gui.session.editing.begin(shot.with_curve(FOCUS, curve.with_key(held)))
    for action in ("Near, in focus, far", "Show curve"):
        gui.do(action)
        for number in (1003, 1006, 1007):
            gui.session.messages.clear()
            gui.session.time.timeline.go(number)
            gui.frame(3)
            assert ("Frame 1006" in gui.session.messages.text) is (number == 1006)
    gui.do("Show curve")


def test_keys_at_the_end_of_time_are_shown_as_far_as_a_shot_goes(gui):
    shot = gui.session.facts.shot.with_key(1003, FOCUS, 2.0).with_key(999_999_999, FOCUS, 3.0)
    gui.session.editing.begin(shot)
    gui.frame(3)
    gui.do("Show curve")
    gui.do("Next key")
    gui.do("Next key")
    gui.do("Show curve")
    assert gui.session.time.timeline.reach.count == 1_000_000

"""Keys by mouse and keyboard: set, chosen, dragged, copied, eased; each is one undo step."""

from dataclasses import replace

import pytest
from imgui_bundle import imgui

from heatlens.core.model.curves.interpolation import Interpolation
from heatlens.core.model.keys.key_choice import KeyId
from heatlens.core.model.shot.lens_parameter import LensParameter
from support.counted_controls import count_frame
from support.gui import Gui
from support.sequences import FIRST, LAST
from support.timeline_window import current_frame, reset_window, ruler_position

K = imgui.Key
FOCUS, F_STOP = LensParameter.FOCUS_DISTANCE, LensParameter.F_STOP
FOCUS_M_BY_FRAME = {1002: 1.5, 1004: 3.0, 1007: 2.0}  # focus distances in metres by frame


@pytest.fixture
def gui(ctx, film) -> Gui:
    return reset_window(film)


@pytest.fixture
def keyed(gui) -> Gui:
    """Set three keys of the focus and one of the f-stop."""
    shot = gui.session.facts.shot
    for number, distance_m in FOCUS_M_BY_FRAME.items():
        shot = shot.with_key(number, FOCUS, distance_m)
    gui.session.editing.begin(shot.with_key(1004, F_STOP, 2.0))
    gui.frame(2)
    return gui


def focus_keys(gui) -> dict[float, float]:
    return {key.frame: key.value for key in gui.session.facts.shot.curves.focus_distance_m.keys}


def f_stop_frames(gui) -> list[float]:
    return [key.frame for key in gui.session.facts.shot.curves.f_stop.keys]


def key_position(gui, number: int, parameter=FOCUS) -> tuple[float, float]:
    x, y, _, _ = gui.rect(f"key {parameter} {number}")
    return x, y


def drag_key(
    gui, number: int, target_frame: int, parameter=FOCUS, via_frames: tuple[int, ...] = ()
) -> None:
    """Drag a key to frame `to`, with the pointer over the frames of `through` on the way."""
    start = key_position(gui, number, parameter)
    gui.press(start)
    for column in (*via_frames, target_frame):
        gui.move((ruler_position(gui, column)[0], start[1] + 1))
    gui.release()


def test_k_key_sets_keys_of_every_parameter_that_has_keys(keyed):
    keyed.session.time.timeline.go_to(1006)
    value = keyed.session.facts.lens.focus_distance_m
    keyed.key(K.k)
    assert focus_keys(keyed) == FOCUS_M_BY_FRAME | {1006: value}
    assert f_stop_frames(keyed) == [1004, 1006] and keyed.undo_count() == 1


def test_click_in_the_picture_sets_a_key_unless_auto_key_is_off(keyed):
    keyed.session.time.timeline.go_to(1005)
    keyed.frame(2)
    keyed.click(keyed.at_picture(60.5, 32.5))
    assert list(focus_keys(keyed)) == [1002, 1004, 1005, 1007]
    keyed.key(K.a)
    keyed.session.time.timeline.go_to(1006)
    keyed.frame(2)
    before = keyed.session.facts.shot
    keyed.click(keyed.at_picture(22.5, 50.5))
    assert keyed.session.facts.shot == before and "auto key" in keyed.session.messages.text


def test_key_drag_is_one_undo_step_and_restores_passed_keys(keyed):
    drag_key(keyed, 1002, 1005, via_frames=(1003, 1004))
    assert focus_keys(keyed) == {1004: 3.0, 1005: 1.5, 1007: 2.0}
    assert keyed.undo_count() == 1
    assert keyed.session.time.keys.selection == {KeyId(FOCUS, 1005)}
    keyed.key(K.z, ctrl=True)
    assert focus_keys(keyed) == FOCUS_M_BY_FRAME


def test_shift_clicked_keys_move_together(keyed):
    keyed.click(key_position(keyed, 1002))
    keyed.hold(K.mod_shift)
    keyed.click(key_position(keyed, 1004, F_STOP))
    keyed.hold(K.mod_shift, down=False)
    keyed.frame(30)
    drag_key(keyed, 1004, 1005, F_STOP)
    assert focus_keys(keyed) == {1003: 1.5, 1004: 3.0, 1007: 2.0}
    assert f_stop_frames(keyed) == [1005] and keyed.undo_count() == 1


def test_box_drag_chooses_keys_and_a_click_beside_clears_them(keyed):
    x0 = ruler_position(keyed, 1003)[0]
    x1 = ruler_position(keyed, 1008)[0]
    y = key_position(keyed, 1004)[1]
    keyed.drag((x0, y - 8), (x1, y + 8))
    assert keyed.session.time.keys.selection == {KeyId(FOCUS, 1004), KeyId(FOCUS, 1007)}
    keyed.frame(30)
    keyed.key(K.delete)
    assert focus_keys(keyed) == {1002: 1.5} and keyed.undo_count() == 1
    keyed.click((x1, y))
    assert not keyed.session.time.keys.selection


def test_ctrl_drag_moves_all_later_keys(keyed):
    keyed.hold(K.mod_ctrl)
    drag_key(keyed, 1004, 1005)
    keyed.hold(K.mod_ctrl, down=False)
    assert focus_keys(keyed) == {1002: 1.5, 1005: 3.0, 1008: 2.0}
    assert f_stop_frames(keyed) == [1005] and keyed.undo_count() == 1


def test_copied_keys_are_pasted_at_the_playhead(keyed):
    keyed.click(key_position(keyed, 1002))
    keyed.hold(K.mod_shift)
    keyed.click(key_position(keyed, 1004))
    keyed.hold(K.mod_shift, down=False)
    keyed.key(K.c, ctrl=True, shift=True)
    keyed.session.time.timeline.go_to(1006)
    keyed.key(K.v, ctrl=True, shift=True)
    assert focus_keys(keyed) == FOCUS_M_BY_FRAME | {1006: 1.5, LAST: 3.0}
    assert keyed.session.time.keys.selection == {KeyId(FOCUS, 1006), KeyId(FOCUS, 1008)}
    assert keyed.undo_count() == 1


def test_ctrl_shift_arrows_move_keys_by_a_frame(keyed):
    keyed.do("Select all keys")
    keyed.key(K.right_arrow, ctrl=True, shift=True)
    assert list(focus_keys(keyed)) == [1003, 1005, 1008] and f_stop_frames(keyed) == [1005]
    keyed.key(K.left_arrow, ctrl=True, shift=True)
    assert focus_keys(keyed) == FOCUS_M_BY_FRAME and current_frame(keyed) == FIRST


@pytest.mark.parametrize("interpolation", list(Interpolation))
def test_interpolation_list_sets_that_of_the_chosen_key(keyed, interpolation):
    keyed.click(key_position(keyed, 1002))
    keyed.frame(30)
    keyed.click(keyed.middle("interpolation"))
    keyed.click(keyed.middle(f"interpolation: {interpolation}"))
    keys = keyed.session.facts.shot.curves.focus_distance_m.keys
    assert [key.interpolation for key in keys] == [interpolation, "smooth", "smooth"]


def test_ease_drag_makes_a_bezier_segment_in_one_undo_step(keyed):
    keyed.click(key_position(keyed, 1002))
    keyed.frame(30)
    position = keyed.middle("ease out")
    keyed.drag(position, (position[0] + 30, position[1]))
    first = keyed.session.facts.shot.curves.focus_distance_m.keys[0]
    assert first.interpolation is Interpolation.BEZIER
    assert first.ease_out.influence_percent > 100 / 3 and keyed.undo_count() == 1


def test_up_and_down_keys_move_to_the_next_key(keyed):
    visited = []
    for _ in range(4):
        keyed.key(K.down_arrow)
        visited.append(current_frame(keyed))
    keyed.key(K.up_arrow)
    assert visited == [1002, 1004, 1007, 1007] and current_frame(keyed) == 1004


def point_at_lens_tab(gui):
    """Move the pointer to the Lens tab, which shows the dots of parameters without keys."""
    gui.move(gui.middle("f-stop"))
    gui.frame(2)


def test_dot_of_a_row_toggles_a_key(gui):
    """The row is there while it has keys; the Lens panel's dot sets the first one."""
    gui.drawn.clear()
    gui.frame()
    assert not {"dot f_stop", "lens dot f_stop", f"dot {FOCUS}"} & gui.drawn.keys()
    point_at_lens_tab(gui)
    gui.click(gui.middle("lens dot f_stop"))
    assert f_stop_frames(gui) == [FIRST]
    gui.session.time.timeline.go_to(FIRST + 2)
    gui.frame(30)
    gui.click(gui.middle("dot f_stop"))
    assert f_stop_frames(gui) == [FIRST, FIRST + 2]
    gui.frame(30)
    gui.click(gui.middle("dot f_stop"))
    assert f_stop_frames(gui) == [FIRST]


def test_sequence_has_at_most_26_controls_and_no_way_to_a_key_without_keys(gui):
    bare = count_frame(gui)
    gui.key(K.k)
    keyed = count_frame(gui)
    to_keys = {("Timeline", "##previous key"), ("Timeline", "##next key")}
    assert to_keys <= set(bare.disabled) and to_keys <= set(keyed.enabled)
    assert len(bare.enabled) <= 26


def test_dot_of_a_lens_control_sets_a_key(gui):
    point_at_lens_tab(gui)
    gui.click(gui.middle(f"lens dot {FOCUS}"))
    assert list(focus_keys(gui)) == [FIRST] and gui.undo_count() == 1


def test_frame_with_an_impossible_lens_is_reported(gui):
    """Both keys are possible, but between them the focal length grows beyond the held focus."""
    shot = gui.session.facts.shot
    for number, distance_m, focal_mm in ((1002, 0.3, 100.0), (1007, 5.0, 800.0)):
        shot = shot.with_key(number, FOCUS, distance_m)
        shot = shot.with_key(number, LensParameter.FOCAL_LENGTH, focal_mm)
    curve = shot.curves.focus_distance_m
    hold_key = replace(curve.keys[0], interpolation=Interpolation.HOLD)
    gui.session.editing.begin(shot.with_curve(FOCUS, curve.with_key(hold_key)))
    for action in ("Near, in focus, far", "Show curve"):
        gui.do(action)
        for number in (1003, 1006, 1007):
            gui.session.messages.clear()
            gui.session.time.timeline.go_to(number)
            gui.frame(3)
            assert ("Frame 1006" in gui.session.messages.text) is (number == 1006)
    gui.do("Show curve")


def test_timeline_reach_is_limited_for_keys_far_away(gui):
    shot = gui.session.facts.shot.with_key(1003, FOCUS, 2.0).with_key(999_999_999, FOCUS, 3.0)
    gui.session.editing.begin(shot)
    gui.frame(3)
    gui.do("Show curve")
    gui.do("Next key")
    gui.do("Next key")
    gui.do("Show curve")
    assert gui.session.time.timeline.visible_range.count == 1_000_000

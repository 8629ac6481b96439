"""Chosen keys: moved, deleted, copied, pasted, bent; by commands and by the hand of the mouse."""

from dataclasses import replace

import pytest

from heatlens.core.base.errors import InputError, LensError
from heatlens.core.model.curves.curve import Curve, Key
from heatlens.core.model.curves.interpolation import Interpolation
from heatlens.core.model.keys import key_choice
from heatlens.core.model.keys.key_choice import KeyId, all_keys, keys_at
from heatlens.core.model.keys.key_rows import CAMERA, RowChoice, key_count, paste_into_row
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.camera_track import CameraTrack, Pose, PoseKey
from heatlens.core.model.shot.framing import Framing
from heatlens.core.model.shot.lens_parameter import FOCUS_SCALES, LensParameter
from heatlens.core.model.shot.shot import Shot
from heatlens.studio.board.key_drag import KeyDrag, keys_in_box, nearest_key
from heatlens.studio.session.keys.key_commands import KeyCommands
from heatlens.studio.session.shot.editing import Editing
from support.shared import shared_of

FOCUS = LensParameter.FOCUS_DISTANCE
STOP = LensParameter.F_STOP
FOCAL = LensParameter.FOCAL_LENGTH
PLAIN = Shot(Lens(50.0, 2.8, 2.0, 36.0))


def framing_with_keys(*frames):
    keys = tuple(PoseKey(frame, Pose((float(frame), 0.0, 0.0))) for frame in frames)
    return Framing(track=CameraTrack(keys))


KEYED = PLAIN.with_key(10, FOCUS, 2.0).with_key(20, FOCUS, 4.0).with_key(20, STOP, 8.0)
FILMED = replace(KEYED, framing=framing_with_keys(10, 30))


class KeyControl:
    """Key commands on an editing of their own, with the messages that they show."""

    def __init__(self, shot, has_camera=False):
        self.messages, self.camera_keys = [], []
        self.clock_s = 0.0
        self.editing = Editing(shot, self.messages.append, clock=lambda: self.clock_s)
        self.keys = KeyCommands(
            shared=shared_of(self.editing, self.messages.append),
            rows=RowChoice(lambda: has_camera),
            set_camera_key=lambda: self.camera_keys.append(self.editing.frame),
        )

    @property
    def shot(self):
        return self.editing.shot

    def frames(self, row=FOCUS):
        return [key.frame for key in self.shot.curves.of(row).keys]


def test_all_keys_identifies_keys_by_row_and_frame():
    assert all_keys(FILMED) == {
        KeyId(FOCUS, 10), KeyId(FOCUS, 20), KeyId(STOP, 20), KeyId(CAMERA, 10), KeyId(CAMERA, 30),
    }  # fmt: skip
    assert keys_at(FILMED, 20) == {KeyId(FOCUS, 20), KeyId(STOP, 20)}
    assert keys_at(FILMED, 20.0009) and not keys_at(FILMED, 20.0011)
    assert key_count(FILMED) == 5 and key_count(KEYED) == 3 and key_count(PLAIN) == 0
    assert key_count(replace(PLAIN, framing=framing_with_keys(7))) == 1
    assert key_choice.key_of(FILMED, KeyId(STOP, 20)).value == 8.0
    assert key_choice.key_of(FILMED, KeyId(CAMERA, 10)) is None


def test_key_commands_apply_to_chosen_keys_else_keys_at_playhead():
    control = KeyControl(KEYED)
    control.editing.frame = 20
    assert control.keys.target_keys == keys_at(KEYED, 20) and control.keys.selection == frozenset()
    control.keys.select_between(FOCUS, 10, 19)
    assert control.keys.target_keys == {KeyId(FOCUS, 10)} == control.keys.selection
    control.keys.select_between(FOCUS, 10, 20)
    assert len(control.keys.selection) == 2
    control.keys.select_all()
    assert control.keys.selection == all_keys(KEYED)
    control.editing.do(PLAIN)
    assert control.keys.selection == frozenset()


def test_moved_keys_stay_chosen_and_report_replaced_keys():
    control = KeyControl(KEYED.with_key(25, FOCUS, 6.0))
    control.keys.select_between(FOCUS, 20, 20)
    control.keys.move(0)
    assert control.frames() == [10, 20, 25]
    control.keys.move(3)
    assert control.frames() == [10, 23, 25] and control.keys.selection == {KeyId(FOCUS, 23)}
    assert control.frames(STOP) == [20] and not control.messages
    control.keys.move(2)
    assert control.frames() == [10, 25] and control.messages[-1].startswith("One key")
    control.editing.undo()
    assert control.frames() == [10, 23, 25]
    control.keys.select_between(FOCUS, 10, 23)
    control.keys.move(2)
    assert control.frames() == [12, 25]


def test_deleting_all_keys_keeps_value_at_the_playhead():
    control = KeyControl(FILMED)
    control.editing.frame = 15
    lens_before = control.editing.lens
    control.keys.select_all()
    control.keys.delete()
    assert not control.shot.key_frames and control.editing.lens == lens_before
    assert control.shot.framing.track.pose_at(99) == FILMED.framing.track.pose_at(15)
    control.editing.undo()
    control.keys.select_between(FOCUS, 10, 10)
    control.keys.delete()
    assert control.frames() == [20] and control.frames(STOP) == [20]


def test_copied_keys_are_pasted_from_playhead_on():
    control = KeyControl(KEYED)
    control.keys.paste()
    assert "No keys" in control.messages[-1]
    control.keys.copy()  # nothing is chosen, and no key lies at the playhead
    control.keys.paste()
    assert control.shot == KEYED
    control.keys.select_all()
    control.keys.copy()
    assert control.messages[-1].startswith("3 ")
    control.editing.frame = 100
    control.keys.paste()
    assert control.frames() == [10, 20, 100, 110] and control.frames(STOP) == [20, 110]
    assert control.keys.selection == {KeyId(FOCUS, 100), KeyId(FOCUS, 110), KeyId(STOP, 110)}
    assert (
        control.shot.lens_at(110).f_stop == 8.0
        and control.shot.lens_at(100).focus_distance_m == 2.0
    )


def test_camera_keys_are_pasted_only_into_a_scene():
    poses = (PoseKey(0.0, Pose((1.0, 0.0, 0.0))), PoseKey(5.0, Pose((2.0, 0.0, 0.0))))
    with pytest.raises(InputError, match="open a scene"):
        paste_into_row(PLAIN, CAMERA, poses, 7.0)
    new = paste_into_row(replace(PLAIN, framing=Framing()), CAMERA, poses, 7.0)
    assert [key.frame for key in new.framing.track.keys] == [7.0, 12.0]
    more = paste_into_row(replace(PLAIN, framing=framing_with_keys(1)), CAMERA, poses, 7.0)
    assert [key.frame for key in more.framing.track.keys] == [1.0, 7.0, 12.0]
    control = KeyControl(FILMED)
    control.keys.select_between(CAMERA, 0, 99)
    control.keys.copy()
    control.editing.do(PLAIN)
    control.keys.paste()
    assert control.shot == PLAIN and "scene" in control.messages[-1]


def test_toggle_here_and_set_here_edit_keys_at_playhead():
    control = KeyControl(KEYED)
    control.editing.frame = 15
    control.keys.toggle_here(STOP)
    assert control.frames(STOP) == [15, 20]
    control.keys.toggle_here(STOP)
    assert control.frames(STOP) == [20]
    before = control.shot.lens_at(15)
    control.keys.set_here()  # focus, and what has keys
    assert control.frames() == [10, 15, 20] and control.frames(STOP) == [15, 20]
    assert control.frames(FOCAL) == [] and control.shot.lens_at(15) == before
    assert control.camera_keys == []
    of_camera = KeyControl(KEYED, has_camera=True)
    of_camera.keys.rows.select(CAMERA)
    of_camera.keys.set_here()
    assert of_camera.camera_keys == [0] and of_camera.shot == KEYED
    of_camera.keys.rows.toggle_curve()  # the camera has no curve, so the focus is chosen
    of_camera.keys.set_here()
    assert of_camera.frames() == [0, 10, 20]


def test_row_choice_refuses_camera_row_without_a_scene():
    rows = RowChoice(lambda: False)
    rows.select(CAMERA)
    assert rows.selected_row is FOCUS and not rows.has_camera and not rows.shows_curve
    rows.select(STOP)
    assert rows.selected_row is STOP
    with_scene = RowChoice(lambda: True)
    with_scene.select(CAMERA)
    assert with_scene.selected_row is CAMERA and with_scene.has_camera
    with_scene.toggle_curve()
    assert with_scene.shows_curve and with_scene.selected_row is FOCUS
    assert CAMERA.words == "camera"


def test_interpolate_sets_segment_after_each_chosen_key():
    control = KeyControl(KEYED)
    control.keys.select_between(FOCUS, 10, 10)
    values = [control.shot.lens_at(frame).focus_distance_m for frame in range(10, 21)]
    control.keys.interpolate(Interpolation.BEZIER)
    first, second = control.shot.curves.focus_distance_m.keys
    assert first.interpolation is Interpolation.BEZIER is not second.interpolation
    bezier_values = [control.shot.lens_at(frame).focus_distance_m for frame in range(10, 21)]
    assert bezier_values == pytest.approx(values, rel=1e-6)  # on the same path
    control.keys.interpolate(Interpolation.HOLD)
    assert control.shot.lens_at(19).focus_distance_m == 2.0


def test_ease_bends_only_the_segment_on_its_side_of_the_key():
    control = KeyControl(KEYED.with_key(30, FOCUS, 2.0))
    control.keys.select_between(FOCUS, 20, 20)
    control.keys.ease(70.0, is_out=True)
    before, middle, after = control.shot.curves.focus_distance_m.keys
    assert middle.ease_out.influence_percent == 70.0
    assert middle.interpolation is Interpolation.BEZIER is not before.interpolation
    control.keys.ease(40.0, is_out=False)
    before, middle, after = control.shot.curves.focus_distance_m.keys
    assert middle.ease_in.influence_percent == 40.0 and middle.ease_out.influence_percent == 70.0
    assert before.interpolation is Interpolation.BEZIER is not after.interpolation
    assert control.editing.is_unsettled  # a drag of the number is one step
    control.keys.ease(140.0, is_out=True)
    assert "0 to 100 %" in control.messages[-1]
    control.keys.select_between(FOCUS, 10, 10)
    control.keys.ease(40.0, is_out=False)  # nothing lies before the first key
    assert control.shot.curves.focus_distance_m.keys[0].ease_in.influence_percent == 40.0


def test_checked_names_frame_of_impossible_lens_between_keys():
    near = Curve((Key(0, 0.5), Key(10, 0.3)), FOCUS_SCALES["dioptres"])
    shot = PLAIN.with_key(0, FOCAL, 50.0).with_key(20, FOCAL, 700.0)
    with pytest.raises(LensError, match="Frame 20"):
        key_choice.check_shot(shot.with_curve(FOCUS, near))
    assert key_choice._frames_to_check(KEYED) == range(0)
    long_shot = PLAIN.with_key(0, FOCAL, 50.0).with_key(5000, FOCAL, 60.0)
    assert key_choice._frames_to_check(long_shot) == range(0, 5001, 6)
    assert key_choice._frames_to_check(
        PLAIN.with_key(0.5, FOCAL, 50.0).with_key(9.5, FOCAL, 60.0)
    ) == (range(11))
    bezier_shot = key_choice.interpolate_keys(KEYED, keys_at(KEYED, 10), Interpolation.BEZIER)
    assert key_choice._frames_to_check(bezier_shot) == range(10, 21)


# Keys dragged with the mouse: a key lies at 10 units a frame, focus at height 50, f-stop at 80.


def key_positions(shot):
    return {key: (10.0 * key.frame, 50.0 if key.row is FOCUS else 80.0) for key in all_keys(shot)}


def slide(shot, chosen, frames, up):
    return key_choice.move_keys(shot, chosen, frames)


class MouseControl(KeyControl):
    """A key control whose keys are pressed and dragged with the mouse."""

    def __init__(self, shot=KEYED):
        super().__init__(shot)
        self.drag = KeyDrag(self.editing, self.keys, self.messages.append)

    def press(self, x, y, shift=False, ctrl=False):
        self.drag.press((x, y), key_positions(self.shot), 6.0, shift, ctrl)

    def move(self, x, y, move=slide):
        self.drag.drag((x, y), key_positions(self.shot), 10.0, move)


def test_nearest_and_inside_find_keys_by_position():
    at = {KeyId(FOCUS, 1): (0.0, 0.0), KeyId(FOCUS, 2): (5.0, 0.0)}
    assert nearest_key((2.0, 0.0), at, 6.0) == KeyId(FOCUS, 1)
    assert nearest_key((3.0, 0.0), at, 6.0) == KeyId(FOCUS, 2)
    assert nearest_key((0.0, 6.0), at, 6.0) == KeyId(FOCUS, 1)
    assert nearest_key((0.0, 6.1), at, 6.0) is None is nearest_key((-6.1, 0.0), at, 6.0)
    assert keys_in_box((5.0, 1.0), (0.0, 0.0), at) == set(at) and keys_in_box(
        (4, 1), (0, 0), at
    ) == {KeyId(FOCUS, 1)}
    assert keys_in_box((0, 1), (5, 2), at) == frozenset()


def test_click_chooses_key_and_row_and_shift_click_toggles():
    mouse = MouseControl()
    mouse.press(202, 78)
    assert mouse.keys.selection == {KeyId(STOP, 20)} and mouse.keys.rows.selected_row is STOP
    assert mouse.drag.is_dragging and mouse.drag.box_corner is None
    mouse.drag.release()
    assert not mouse.drag.is_dragging
    mouse.press(100, 50, shift=True)
    assert mouse.keys.selection == {KeyId(STOP, 20), KeyId(FOCUS, 10)}
    mouse.drag.release()
    mouse.press(100, 50, shift=True)
    assert mouse.keys.selection == {KeyId(STOP, 20)}
    mouse.drag.release()
    mouse.press(500, 500)
    mouse.drag.release()
    assert mouse.keys.selection == frozenset()


def test_drag_moves_chosen_keys_relative_to_their_start():
    mouse = MouseControl(KEYED.with_key(25, FOCUS, 6.0))
    mouse.press(200, 50)
    mouse.move(251, 50)  # over the key at 25
    assert mouse.frames() == [10, 25]
    mouse.move(234, 50)
    assert mouse.frames() == [10, 23, 25] and mouse.keys.selection == {KeyId(FOCUS, 23)}
    mouse.move(251, 50)
    mouse.drag.release()
    assert "One key" in mouse.messages[-1] and not mouse.editing.is_unsettled
    mouse.editing.undo()
    assert mouse.frames() == [10, 20, 25]
    mouse.move(300, 50)  # nothing is held
    assert mouse.frames() == [10, 20, 25]


def test_drag_passes_frames_and_height_to_its_move_function():
    ups = []

    def lift(shot, chosen, frames, up):
        ups.append((frames, up))
        return shot, chosen

    mouse = MouseControl()
    mouse.press(200, 50)
    mouse.move(214, 20, lift)
    mouse.move(216, 60, lift)
    assert ups == [(1, 30), (2, -10)]


def test_ctrl_drag_moves_all_later_keys_and_stops_at_earlier_key():
    mouse = MouseControl(KEYED.with_key(25, FOCUS, 6.0))
    mouse.press(200, 50, ctrl=True)
    mouse.move(240, 50)
    assert mouse.frames() == [10, 24, 29] and mouse.frames(STOP) == [24]
    mouse.move(0, 50)
    assert mouse.frames() == [10, 11, 16] and mouse.keys.selection == frozenset()
    mouse.drag.release()
    mouse.press(100, 50, ctrl=True)
    mouse.move(-900, 50)  # nothing lies before the first
    assert mouse.frames()[0] == -90


def test_box_drag_chooses_keys_and_shift_adds_to_them():
    mouse = MouseControl()
    mouse.press(90, 40)
    assert mouse.drag.box_corner == (90, 40)
    mouse.move(110, 60)
    assert mouse.keys.selection == {KeyId(FOCUS, 10)}
    mouse.drag.release()
    mouse.press(190, 70, shift=True)
    mouse.move(210, 90)
    assert mouse.keys.selection == {KeyId(FOCUS, 10), KeyId(STOP, 20)}
    mouse.drag.release()
    assert mouse.shot == KEYED


def test_drag_to_impossible_lens_reports_and_changes_nothing():
    mouse = MouseControl()
    mouse.press(200, 50)

    def too_near(shot, chosen, frames, up):
        return shot.with_curve(FOCUS, shot.curves.of(FOCUS).with_key(Key(20, 0.01))), chosen

    mouse.move(210, 50, lambda *args: (key_choice.check_shot(too_near(*args)[0]), args[1]))
    assert mouse.messages and mouse.shot == KEYED

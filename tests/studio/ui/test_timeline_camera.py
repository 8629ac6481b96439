"""Camera keys of a scene on the timeline: dragged, box-selected, copied and deleted."""

from collections.abc import Iterator
from dataclasses import replace

import pytest
from imgui_bundle import imgui

from heatlens.core.base.errors import InputError
from heatlens.core.model.keys.key_choice import KeyId, all_keys, copy_keys, delete_keys, paste_keys
from heatlens.core.model.keys.key_rows import CAMERA
from heatlens.core.model.shot.camera_track import CameraTrack, Pose, PoseKey
from heatlens.core.model.shot.lens_parameter import LensParameter
from support.gltf_files import GltfWriter
from support.gui import Gui, gui_of
from support.session_files import QUICK

K = imgui.Key
FOCUS = LensParameter.FOCUS_DISTANCE
RIGHT_M_BY_FRAME = {3: 0.0, 6: 0.4, 12: 0.8}  # metres to the right by frame


@pytest.fixture(scope="module")
def window(session_context, tmp_path_factory) -> Iterator[Gui]:
    writer = GltfWriter()
    square = writer.node(mesh=writer.mesh())
    writer.animate(square, "translation", [0.0, 1.0], [[0.0, 0.0, 0.0], [0.0, 0.0, -1.0]])
    scene = writer.write(tmp_path_factory.mktemp("scene") / "scene.glb")
    with gui_of(session_context, scene, defocus=QUICK) as gui:
        yield gui


@pytest.fixture
def gui(ctx, window) -> Gui:
    """Open a scene whose camera has three keys and whose focus has one."""
    session, opened = window.session, window.session.source.opened.first
    keys = tuple(PoseKey(f, Pose((x, 0.5, 3.0))) for f, x in RIGHT_M_BY_FRAME.items())
    framing = replace(opened.shot.framing, width_px=48, height_px=27, track=CameraTrack(keys))
    shot = replace(opened.shot, defocus=QUICK, framing=framing).with_key(6, FOCUS, 3.0)
    session.editing.frame, session.messages.text = opened.frame, ""
    session.editing.begin(shot)
    session.time.keys.select(frozenset())
    window.io.clear_input_keys()
    window.io.add_mouse_pos_event(-1e4, -1e4)
    window.frame(30)
    return window


def camera_right_m(gui) -> dict[float, float]:
    """Return the x position of the camera in meters by key frame."""
    return {key.frame: key.pose.position_m[0] for key in gui.session.facts.shot.framing.track.keys}


def key_position(gui, frame: int, row=CAMERA) -> tuple[float, float]:
    x, y, _, _ = gui.rect(f"key {row} {frame}")
    return x, y


def drag_key(gui, frame: int, target_frame: float, via_frames: tuple[float, ...] = ()) -> None:
    (x, y), (next_x, _) = key_position(gui, 6), key_position(gui, 12)
    start = key_position(gui, frame)
    gui.press(start)
    for column in (*via_frames, target_frame):
        gui.move((x + (column - 6) * (next_x - x) / 6, y + 2))
    gui.release()


def test_stretch_grips_lie_below_every_row(gui):
    """The default height of the timeline holds five rows and the grips without scrolling."""
    lens, shot = gui.session.facts.lens, gui.session.facts.shot
    shown = (FOCUS, LensParameter.F_STOP, LensParameter.FOCAL_LENGTH, LensParameter.SQUEEZE)
    for parameter in shown:
        shot = shot.with_key(6, parameter, getattr(lens, parameter))
    gui.session.editing.begin(shot)
    gui.session.time.keys.select(all_keys(shot))
    gui.frame(2)
    for grip in (gui.rect("stretch first"), gui.rect("stretch last")):
        assert all(grip[1] >= gui.rect(f"row {row}")[3] for row in (*shown, CAMERA))
        assert grip[3] <= gui.rect("keys")[3] <= gui.size[1]
    assert gui.rect("row camera")[3] - gui.rect("row camera")[1] >= imgui.get_font_size()


def test_camera_key_drag_snaps_to_a_frame_in_one_undo_step(gui):
    drag_key(gui, 6, 9.3)
    assert camera_right_m(gui) == {3: 0.0, 9: 0.4, 12: 0.8}
    assert gui.undo_count() == 1 and gui.session.time.keys.selection == {KeyId(CAMERA, 9)}
    gui.key(K.z, ctrl=True)
    assert camera_right_m(gui) == RIGHT_M_BY_FRAME


def test_box_selected_lens_and_camera_keys_move_together(gui):
    (x, y), (_, lens_y) = key_position(gui, 6), key_position(gui, 6, FOCUS)
    gui.drag((x - 9, lens_y - 7), (x + 9, y + 7))
    assert gui.session.time.keys.selection == {KeyId(CAMERA, 6), KeyId(FOCUS, 6)}
    gui.frame(30)
    drag_key(gui, 6, 8)
    assert camera_right_m(gui) == {3: 0.0, 8: 0.4, 12: 0.8}
    assert gui.session.facts.shot.key_frames == (8,) and gui.undo_count() == 1


def test_delete_of_all_camera_keys_keeps_the_current_pose(gui):
    gui.click(key_position(gui, 6))
    gui.key(K.delete)
    assert camera_right_m(gui) == {3: 0.0, 12: 0.8} and gui.session.facts.shot.key_frames == (6,)
    gui.session.time.timeline.go_to(12)
    gui.frame(2)
    gui.key(K.a, ctrl=True, shift=True)
    gui.key(K.delete)
    assert all_keys(gui.session.facts.shot) == frozenset()
    assert gui.session.scenes.pose.position_m == (0.8, 0.5, 3.0)
    assert gui.undo_count() == 2


def test_k_key_sets_a_key_of_the_chosen_row(gui):
    gui.session.time.timeline.go_to(9)
    gui.frame(2)
    pose_before = gui.session.scenes.pose
    gui.click(gui.middle("row camera"))
    gui.key(K.k)
    assert set(camera_right_m(gui)) == {3, 6, 9, 12} and gui.session.facts.shot.key_frames == (6,)
    assert gui.session.scenes.pose.position_m == pytest.approx(pose_before.position_m)
    assert gui.undo_count() == 1
    gui.click(gui.middle(f"row {FOCUS}"))
    gui.key(K.k)
    assert gui.session.facts.shot.key_frames == (6, 9) and gui.undo_count() == 2


def test_click_on_a_key_chooses_its_row(gui):
    for row in (CAMERA, FOCUS):
        gui.click(key_position(gui, 6, row))
        assert gui.session.time.keys.rows.selected_row is row
        gui.later()


def test_interpolation_cannot_be_set_for_camera_keys(gui):
    gui.click(key_position(gui, 6))
    before = gui.session.facts.shot
    gui.do("Interpolate hold after key")
    gui.click(gui.middle("interpolation"))
    assert gui.session.facts.shot == before
    gui.key(K.escape)


def test_pasting_camera_keys_into_a_plate_is_refused(gui):
    shot = gui.session.facts.shot
    keys = copy_keys(shot, frozenset({KeyId(CAMERA, 3.0)}))
    with pytest.raises(InputError, match="open a scene"):
        paste_keys(replace(shot, framing=None), keys, 5.0)


def test_pasting_camera_keys_gives_the_shot_a_camera_track(gui):
    shot = gui.session.facts.shot
    keys = copy_keys(shot, frozenset({KeyId(CAMERA, 3.0), KeyId(CAMERA, 6.0)}))
    looking = replace(shot, framing=replace(shot.framing, track=None))
    after, chosen = paste_keys(looking, keys, 20.0)
    assert after.camera_key_frames == (20.0, 23.0)
    assert chosen == {KeyId(CAMERA, 20.0), KeyId(CAMERA, 23.0)}
    assert delete_keys(after, chosen, 21.0).framing.track.keys == (
        PoseKey(21.0, after.framing.track.pose_at(21.0)),
    )

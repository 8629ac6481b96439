"""The keys of a scene's camera on the timeline: dragged, gathered, copied and deleted as others."""

from collections.abc import Iterator
from dataclasses import replace

import pytest
from imgui_bundle import imgui

from heatlens.core.base.errors import InputError
from heatlens.core.model.shot.framing import CameraTrack, Pose, PoseKey
from heatlens.core.model.shot.lens_parameter import LensParameter
from heatlens.studio.session.keys.key_choice import KeyId, all_keys, copied, deleted, pasted
from heatlens.studio.session.keys.key_rows import CAMERA, ROWS
from support.gltf_files import GltfWriter
from support.gui import Gui, gui_of
from support.session_files import QUICK

K = imgui.Key
FOCUS = LensParameter.FOCUS_DISTANCE
RARE = [it for it in LensParameter if it.is_rare]  # rows of tilt and split, if they are used
PLACES = {3: 0.0, 6: 0.4, 12: 0.8}  # metres to the right by frame


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
    keys = tuple(PoseKey(f, Pose((x, 0.5, 3.0))) for f, x in PLACES.items())
    framing = replace(opened.shot.framing, width_px=48, height_px=27, track=CameraTrack(keys))
    shot = replace(opened.shot, defocus=QUICK, framing=framing).with_key(6, FOCUS, 3.0)
    session.editing.frame, session.messages.text = opened.frame, ""
    session.editing.begin(shot)
    session.time.keys.choose(frozenset())
    window.io.clear_input_keys()
    window.io.add_mouse_pos_event(-1e4, -1e4)
    window.frame(30)
    return window


def camera(gui) -> dict[float, float]:
    """Return metres to the right by frame."""
    return {key.frame: key.pose.position_m[0] for key in gui.session.facts.shot.framing.track.keys}


def steps(gui) -> int:
    gui.rest()
    return len(gui.session.editing.history.past)


def place(gui, frame: int, row=CAMERA) -> tuple[float, float]:
    x, y, _, _ = gui.rect(f"key {row} {frame}")
    return x, y


def drag_key(gui, frame: int, to: float, through: tuple[float, ...] = ()) -> None:
    (x, y), (next_x, _) = place(gui, 6), place(gui, 12)
    start = place(gui, frame)
    gui.press(start)
    for column in (*through, to):
        gui.move((x + (column - 6) * (next_x - x) / 6, y + 2))
    gui.release()


def test_the_grips_of_the_chosen_keys_lie_below_every_row(gui):
    """Five rows in a timeline as high as it is at first, without scrolling."""
    gui.session.time.keys.choose(all_keys(gui.session.facts.shot))
    gui.frame(2)
    for grip in (gui.rect("stretch first"), gui.rect("stretch last")):
        assert all(grip[1] >= gui.rect(f"row {row}")[3] for row in ROWS if row not in RARE)
        assert grip[3] <= gui.rect("keys")[3] <= gui.size[1]
    assert gui.rect("row camera")[3] - gui.rect("row camera")[1] >= imgui.get_font_size()


def test_a_key_of_the_camera_is_dragged_to_a_whole_frame_in_one_step(gui):
    drag_key(gui, 6, 9.3)
    assert camera(gui) == {3: 0.0, 9: 0.4, 12: 0.8}
    assert steps(gui) == 1 and gui.session.time.keys.chosen == {KeyId(CAMERA, 9)}
    gui.key(K.z, ctrl=True)
    assert camera(gui) == PLACES


def test_keys_of_lens_and_camera_are_gathered_and_go_together(gui):
    (x, y), (_, lens_y) = place(gui, 6), place(gui, 6, FOCUS)
    gui.drag((x - 9, lens_y - 7), (x + 9, y + 7))
    assert gui.session.time.keys.chosen == {KeyId(CAMERA, 6), KeyId(FOCUS, 6)}
    gui.frame(30)
    drag_key(gui, 6, 8)
    assert camera(gui) == {3: 0.0, 8: 0.4, 12: 0.8}
    assert gui.session.facts.shot.key_frames == (8,) and steps(gui) == 1


def test_delete_takes_the_chosen_and_the_last_leave_the_camera_where_it_stands(gui):
    gui.click(place(gui, 6))
    gui.key(K.delete)
    assert camera(gui) == {3: 0.0, 12: 0.8} and gui.session.facts.shot.key_frames == (6,)
    gui.session.time.timeline.go(12)
    gui.frame(2)
    gui.key(K.a, ctrl=True, shift=True)
    gui.key(K.delete)
    assert all_keys(gui.session.facts.shot) == frozenset()
    assert gui.session.scenes.pose.position_m == (0.8, 0.5, 3.0)
    assert steps(gui) == 2


def test_k_keys_the_camera_while_its_row_is_the_chosen_one(gui):
    gui.session.time.timeline.go(9)
    gui.frame(2)
    stood = gui.session.scenes.pose
    gui.click(gui.middle("row camera"))
    gui.key(K.k)
    assert set(camera(gui)) == {3, 6, 9, 12} and gui.session.facts.shot.key_frames == (6,)
    assert gui.session.scenes.pose.position_m == pytest.approx(stood.position_m)
    assert steps(gui) == 1
    gui.click(gui.middle(f"row {FOCUS}"))
    gui.key(K.k)
    assert gui.session.facts.shot.key_frames == (6, 9) and steps(gui) == 2


def test_a_click_on_a_key_chooses_its_row(gui):
    for row in (CAMERA, FOCUS):
        gui.click(place(gui, 6, row))
        assert gui.session.time.keys.rows.chosen is row
        gui.later()


def test_what_follows_a_key_is_no_choice_of_the_camera(gui):
    gui.click(place(gui, 6))
    before = gui.session.facts.shot
    gui.do("Interpolate hold after key")
    gui.click(gui.middle("interpolation"))
    assert gui.session.facts.shot == before
    gui.key(K.escape)


def test_a_plate_takes_no_keys_of_a_camera_and_says_so(gui):
    shot = gui.session.facts.shot
    keys = copied(shot, frozenset({KeyId(CAMERA, 3.0)}))
    with pytest.raises(InputError, match="open a scene"):
        pasted(replace(shot, framing=None), keys, 5.0)


def test_a_camera_of_the_scene_becomes_the_shots_own_where_keys_are_pasted(gui):
    shot = gui.session.facts.shot
    keys = copied(shot, frozenset({KeyId(CAMERA, 3.0), KeyId(CAMERA, 6.0)}))
    looking = replace(shot, framing=replace(shot.framing, track=None))
    after, chosen = pasted(looking, keys, 20.0)
    assert after.camera_key_frames == (20.0, 23.0)
    assert chosen == {KeyId(CAMERA, 20.0), KeyId(CAMERA, 23.0)}
    assert deleted(after, chosen, 21.0).framing.track.keys == (
        PoseKey(21.0, after.framing.track.pose_at(21.0)),
    )

"""A change of the focal length moves the camera so that a marked subject keeps its size."""

from dataclasses import replace

import numpy as np
import pytest

from heatlens.core.model.marks.marks import DistanceMark, PointMark
from heatlens.core.model.shot.camera_track import CameraTrack, PoseKey
from heatlens.core.model.shot.lens_parameter import LensParameter
from heatlens.core.model.view.orbit import CameraDrag
from heatlens.studio.board.commands import named_commands
from heatlens.studio.board.session import Session
from heatlens.studio.settings.preferences import Preferences
from heatlens.studio.settings.start import Start
from support.evening import run_until, run_until_settled
from support.session_files import QUICK, room_file, write_scene


def open_with_marks(renderer, folder, path):
    session = Session(
        renderer, Start(str(path), defocus=QUICK), preferences=Preferences.load(folder / "kept")
    )
    session.begin()
    run_until(session, lambda: session.source.opened is not None, "the source")
    shot = replace(session.editing.shot, marks=(DistanceMark("A", 3.0), DistanceMark("B", 40.0)))
    if shot.framing is not None:  # a small picture is whole soon
        shot = replace(shot, framing=replace(shot.framing, width_px=320, height_px=180))
    lens = replace(shot.lens, focal_length_mm=35.0, focus_distance_m=4.0)
    session.editing.begin(replace(shot, lens=lens))
    run_until_settled(session)
    return session


@pytest.fixture
def session(ctx, renderer, tmp_path):
    session = open_with_marks(renderer, tmp_path, write_scene(tmp_path / "a.glb"))
    yield session
    session.close()


def zoom(session, length_mm: float) -> None:
    lens = session.editing.lens
    session.editing.edit_lens(replace(lens, focal_length_mm=length_mm))


def test_zoom_moves_camera_to_keep_size_at_the_chosen_mark(session):
    size, pose = session.scenes.size, session.scenes.pose
    zoom(session, 50.0)
    assert session.scenes.pose == pose and session.facts.shot.marks[0].distance_m == 3.0
    session.editing.settle()
    size.chosen = "A"
    for length_mm in (55.0, 70.0, 100.0):  # a drag
        zoom(session, length_mm)
    session.editing.settle()
    assert session.facts.shot.marks[0].distance_m == pytest.approx(6.0)
    assert session.facts.lens.focus_distance_m == pytest.approx(7.0)
    back = np.subtract(session.scenes.pose.position_m, pose.position_m)
    np.testing.assert_allclose(back, 3.0 * pose.turn[:, 2], atol=1e-6)
    session.editing.undo()
    assert session.scenes.pose == pose and session.facts.lens.focal_length_mm == 50.0


def test_dolly_changes_focal_length_to_keep_size_at_the_mark(session):
    session.scenes.size.chosen = "A"
    session.scenes.move(CameraDrag("dolly", down=1.0))
    lens, mark = session.facts.lens, session.facts.shot.marks[0]
    assert lens.focal_length_mm < 35.0 and mark.distance_m < 3.0
    assert lens.focal_length_mm / mark.distance_m == pytest.approx(35.0 / 3.0)
    session.scenes.move(CameraDrag("orbit", right=0.1))  # others are as before
    assert session.facts.lens == lens


def test_doubled_focal_length_doubles_distance_to_the_chosen_point_mark(session):
    shot = session.facts.shot
    x, y = (side // 2 for side in shot.framing.size)
    session.editing.do(replace(shot, marks=(PointMark("P", float(x), float(y)),)))
    depth_m = session.scenes.point_m(x, y, session.editing.frame)
    session.scenes.size.chosen = "P"
    zoom(session, 2 * shot.lens.focal_length_mm)
    assert session.scenes.point_m(x, y, session.editing.frame) == pytest.approx(
        2 * depth_m, rel=0.02
    )


def test_zoom_that_passes_another_mark_is_refused_and_reported(session):
    session.scenes.size.chosen = "B"
    shot = session.facts.shot
    zoom(session, 20.0)
    assert "past mark A at 3 m" in session.messages.text and session.facts.shot == shot


def test_dolly_zoom_keys_focal_length_along_the_camera_track(session):
    size, shot = session.scenes.size, session.facts.shot
    size.dolly_zoom("camera")
    assert (
        "Choose first what keeps its size" in session.messages.text and session.facts.shot == shot
    )
    pose = session.scenes.pose
    near = replace(pose, position_m=tuple(pose.position_m - pose.turn[:, 2]))
    track = CameraTrack((PoseKey(1, pose), PoseKey(9, near)))
    session.editing.do(replace(shot, framing=replace(shot.framing, track=track)))
    size.chosen = "A"
    session.editing.frame = 1
    size.dolly_zoom("length")
    keys = session.facts.shot.curves.of(LensParameter.FOCAL_LENGTH).keys
    assert len(keys) >= 2 and session.facts.shot.lens_at(9).focal_length_mm == pytest.approx(
        35.0 * 2 / 3, rel=0.01
    )


def test_keep_size_command_toggles_mark_nearest_to_the_focus(session):
    command = next(it for it in named_commands(session) if it.name == "Keep the size of a mark")
    command.do()
    assert session.scenes.size.chosen == "A"
    command.do()
    assert session.scenes.size.chosen is None and "zooms" in session.messages.text
    session.editing.edit_lens(replace(session.editing.lens, focus_distance_m=30.0))
    command.do()
    assert session.scenes.size.chosen == "B"
    session.editing.do(replace(session.facts.shot, marks=()))
    command.do()
    assert "Set a mark first" in session.messages.text and session.scenes.size.chosen is None


def test_deleted_mark_is_no_longer_chosen_for_size_keeping(session):
    session.scenes.size.chosen = "A"
    session.editing.do(replace(session.facts.shot, marks=()))
    assert session.scenes.size.chosen is None
    zoom(session, 70.0)
    assert session.facts.lens.focal_length_mm == 70.0


def test_size_keeping_on_a_plate_is_refused_and_shows_the_crop(ctx, renderer, tmp_path):
    session = open_with_marks(renderer, tmp_path, room_file(tmp_path / "a.exr"))
    session.scenes.size.chosen = "A"
    zoom(session, 70.0)
    assert session.facts.lens.focal_length_mm == 35.0
    assert "A plate is seen from one place" in session.messages.text
    assert session.facts.crop == pytest.approx(0.5)
    session.scenes.size.chosen = None
    assert session.facts.crop is None
    zoom(session, 70.0)
    assert session.facts.lens.focal_length_mm == 70.0
    session.close()

"""`heatlens view --camera`: the window begins with the lens of a camera file."""

from dataclasses import replace

import numpy as np
import pytest

from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.shot import Shot
from heatlens.fronts.commands.main import main
from heatlens.media.camera.camera_file import write_camera
from heatlens.media.documents.shot_file import write_shot
from support.cameras import FRAMES, moving_camera
from support.gui import gui_of
from support.sequences import sequence_files
from support.session_files import LENS, QUICK, room_file


@pytest.fixture
def started(monkeypatch):
    """Return what the window is started with, in the place of a window."""
    starts = []
    monkeypatch.setattr("heatlens.studio.ui.window.run_window", starts.append)
    return starts


def camera_file(path, **changes):
    write_camera(path, moving_camera(**changes))
    return path


def assert_lens_of_camera(shot, camera, kept=()):
    for at, frame in enumerate(camera.frames):
        lens = shot.lens_at(frame)
        for name in {"focal_length_mm", "f_stop", "focus_distance_m"}.difference(kept):
            wanted = getattr(camera, name)[at]
            assert getattr(lens, name) == pytest.approx(wanted, rel=1e-6), (frame, name)


def test_the_window_begins_with_lens_keys_frames_and_rate_of_the_camera(ctx, tmp_path):
    camera, plate = moving_camera(), room_file(tmp_path / "room.exr")
    with gui_of(ctx, plate, camera=camera, defocus=QUICK) as gui:
        shot = gui.session.facts.shot
        assert_lens_of_camera(shot, camera)
        assert (shot.frames, shot.frames_per_second) == (FRAMES, 25.0)
        assert gui.session.editing.frame == FRAMES.first and gui.session.time.timeline.has_time
        gui.session.editing.edit_lens(replace(gui.session.facts.lens, f_stop=8.0))
        gui.session.lens.commands.reset()
        assert (
            gui.session.facts.lens
            == gui.session.lens.commands.start_lens.lens
            == shot.lens_at(FRAMES.first)
        )


def test_what_the_options_say_wins_and_the_plate_keeps_its_frames(ctx, tmp_path):
    camera, plates = moving_camera(), sequence_files(tmp_path, 1003, 1005)
    given = {"f_stop": 4.0, "focal_length_mm": 35.0}
    with gui_of(ctx, plates, camera=camera, lens=given, defocus=QUICK) as gui:
        shot = gui.session.facts.shot
        assert_lens_of_camera(shot, camera, kept=given)
        lenses = [shot.lens_at(frame) for frame in FRAMES]
        assert {(lens.f_stop, lens.focal_length_mm) for lens in lenses} == {(4.0, 35.0)}
        assert (shot.frames.first, shot.frames.last) == (1003, 1005)


def test_the_camera_is_that_of_its_plate_alone(ctx, tmp_path):
    first, second = (room_file(tmp_path / name) for name in ("first.exr", "second.exr"))
    with gui_of(ctx, first, camera=moving_camera(), defocus=QUICK) as gui:
        gui.open(second)
        assert gui.session.facts.lens == LENS and not gui.session.facts.shot.key_frames


def test_a_shot_is_seen_through_the_camera_and_is_not_saved_so(ctx, tmp_path):
    path, plate = tmp_path / "s.heatlens.json", room_file(tmp_path / "room.exr")
    write_shot(path, Shot(Lens(20.0, 5.6, 3.0, 24.0), QUICK, source=str(plate)))
    with gui_of(ctx, path, camera=moving_camera()) as gui:
        assert_lens_of_camera(gui.session.facts.shot, moving_camera())
        assert not gui.session.files.documents.is_saved


def test_a_camera_that_makes_no_lens_with_the_options_is_said(ctx, tmp_path):
    plate, camera = room_file(tmp_path / "room.exr"), moving_camera()
    with gui_of(ctx, plate, camera=camera, lens={"focal_length_mm": 1000.0}) as gui:
        assert "beyond the focal length" in gui.session.messages.text
        assert gui.session.facts.lens == LENS and not gui.session.facts.shot.key_frames


@pytest.mark.parametrize("name", ["cam.json", "cam.csv", "cam.usda"])
def test_the_file_is_read_before_the_window_opens(started, tmp_path, name):
    plate, path = room_file(tmp_path / "room.exr"), camera_file(tmp_path / name)
    assert main(["view", str(plate), "--camera", str(path), "--f-stop", "4"]) == 0
    ((start,),) = [started]
    assert start.lens == {"f_stop": 4.0}
    assert np.allclose(start.camera.focal_length_mm, moving_camera().focal_length_mm, rtol=1e-6)


@pytest.mark.parametrize("name", ["none.json", "torn.json", "cam.nk", "none.usda", "torn.csv"])
def test_what_is_no_camera_is_one_sentence_and_no_window(started, capsys, tmp_path, name):
    plate, path = room_file(tmp_path / "room.exr"), tmp_path / name
    if name.startswith("torn"):
        path.write_bytes(camera_file(tmp_path / f"cam{path.suffix}").read_bytes()[:150])
    assert main(["view", str(plate), "--camera", str(path)]) == 2
    said = capsys.readouterr()
    assert said.out == "" and len(said.err.splitlines()) == 1 and str(path) in said.err
    assert not started


def test_a_sensor_that_changes_is_for_an_option_to_say(started, capsys, tmp_path):
    plate = room_file(tmp_path / "room.exr")
    widths = tuple(np.linspace(24.0, 36.0, FRAMES.count))
    words = ["view", str(plate), "--camera", str(camera_file(tmp_path / "c.json"))]
    camera_file(tmp_path / "c.json", sensor_width_mm=widths)
    assert main(words) == 2 and "sensor" in capsys.readouterr().err
    assert main([*words, "--sensor-width", "30"]) == 0 and started

"""Test `heatlens view --camera`: the window starts with the lens of a camera file."""

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
def window_starts(monkeypatch):
    """Return the list of starts that are recorded in place of opening a window."""
    starts = []
    monkeypatch.setattr("heatlens.studio.ui.window.run_window", starts.append)
    return starts


def camera_file(path, **changes):
    write_camera(path, moving_camera(**changes))
    return path


def assert_lens_of_camera(shot, camera, overridden=()):
    for index, frame in enumerate(camera.frames):
        lens = shot.lens_at(frame)
        for name in {"focal_length_mm", "f_stop", "focus_distance_m"}.difference(overridden):
            expected = getattr(camera, name)[index]
            assert getattr(lens, name) == pytest.approx(expected, rel=1e-6), (frame, name)


def test_view_camera_sets_lens_keys_frames_and_rate(ctx, tmp_path):
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


def test_view_options_override_camera_and_plate_keeps_frames(ctx, tmp_path):
    camera, plates = moving_camera(), sequence_files(tmp_path, 1003, 1005)
    lens_options = {"f_stop": 4.0, "focal_length_mm": 35.0}
    with gui_of(ctx, plates, camera=camera, lens=lens_options, defocus=QUICK) as gui:
        shot = gui.session.facts.shot
        assert_lens_of_camera(shot, camera, overridden=lens_options)
        lenses = [shot.lens_at(frame) for frame in FRAMES]
        assert {(lens.f_stop, lens.focal_length_mm) for lens in lenses} == {(4.0, 35.0)}
        assert (shot.frames.first, shot.frames.last) == (1003, 1005)


def test_view_camera_applies_to_first_plate_only(ctx, tmp_path):
    first, second = (room_file(tmp_path / name) for name in ("first.exr", "second.exr"))
    with gui_of(ctx, first, camera=moving_camera(), defocus=QUICK) as gui:
        gui.open(second)
        assert gui.session.facts.lens == LENS and not gui.session.facts.shot.key_frames


def test_view_camera_replaces_lens_of_shot_without_saving(ctx, tmp_path):
    path, plate = tmp_path / "s.heatlens.json", room_file(tmp_path / "room.exr")
    write_shot(path, Shot(Lens(20.0, 5.6, 3.0, 24.0), QUICK, source=str(plate)))
    with gui_of(ctx, path, camera=moving_camera()) as gui:
        assert_lens_of_camera(gui.session.facts.shot, moving_camera())
        assert not gui.session.files.documents.is_saved


def test_view_reports_camera_that_conflicts_with_options(ctx, tmp_path):
    plate, camera = room_file(tmp_path / "room.exr"), moving_camera()
    with gui_of(ctx, plate, camera=camera, lens={"focal_length_mm": 1000.0}) as gui:
        assert "beyond the focal length" in gui.session.messages.text
        assert gui.session.facts.lens == LENS and not gui.session.facts.shot.key_frames


@pytest.mark.parametrize("name", ["cam.json", "cam.csv", "cam.usda"])
def test_view_reads_camera_file_before_window_opens(window_starts, tmp_path, name):
    plate, path = room_file(tmp_path / "room.exr"), camera_file(tmp_path / name)
    assert main(["view", str(plate), "--camera", str(path), "--f-stop", "4"]) == 0
    ((start,),) = [window_starts]
    assert start.lens == {"f_stop": 4.0}
    assert np.allclose(start.camera.focal_length_mm, moving_camera().focal_length_mm, rtol=1e-6)


@pytest.mark.parametrize("name", ["none.json", "torn.json", "cam.nk", "none.usda", "torn.csv"])
def test_view_rejects_invalid_camera_file_without_window(window_starts, capsys, tmp_path, name):
    plate, path = room_file(tmp_path / "room.exr"), tmp_path / name
    if name.startswith("torn"):
        path.write_bytes(camera_file(tmp_path / f"cam{path.suffix}").read_bytes()[:150])
    assert main(["view", str(plate), "--camera", str(path)]) == 2
    captured = capsys.readouterr()
    assert captured.out == "" and len(captured.err.splitlines()) == 1 and str(path) in captured.err
    assert not window_starts


def test_view_camera_with_changing_sensor_needs_sensor_option(window_starts, capsys, tmp_path):
    plate = room_file(tmp_path / "room.exr")
    widths = tuple(np.linspace(24.0, 36.0, FRAMES.count))
    words = ["view", str(plate), "--camera", str(camera_file(tmp_path / "c.json"))]
    camera_file(tmp_path / "c.json", sensor_width_mm=widths)
    assert main(words) == 2 and "sensor" in capsys.readouterr().err
    assert main([*words, "--sensor-width", "30"]) == 0 and window_starts

"""A camera file gives its lens to the shot in the window."""

from dataclasses import replace

import pytest

from heatlens.core.model.curves.frames import FrameRange
from heatlens.core.model.shot.lens_parameter import LensParameter
from heatlens.core.model.shot.shot import Shot
from heatlens.media.camera.camera_file import write_camera
from heatlens.render.source.named import camera_of_shot


def shot_with_pull(gui) -> Shot:
    """Return the shot of the window with another lens and a focus pull over five frames."""
    shot = replace(gui.session.facts.shot, frames=FrameRange(1, 5))
    shot = replace(shot, lens=replace(shot.lens, focal_length_mm=85.0, f_stop=2.0))
    focus = LensParameter.FOCUS_DISTANCE
    return shot.with_key(1, focus, 1.25).with_key(5, focus, 2.5)


@pytest.mark.parametrize("suffix", [".json", ".csv"])
def test_camera_import_takes_lens_and_focus_keys_in_one_undo_step(gui, tmp_path, suffix):
    path, before = tmp_path / f"cam{suffix}", gui.session.facts.shot
    expected = shot_with_pull(gui)
    write_camera(path, camera_of_shot(expected, "cam"))
    gui.session.files.commands.cameras.begin(path)
    gui.until(lambda: gui.session.facts.shot != before, "the camera")
    for frame in range(1, 6):
        lens = gui.session.facts.shot.lens_at(frame)
        assert lens.focal_length_mm == pytest.approx(85.0, rel=1e-6)
        assert lens.f_stop == pytest.approx(2.0, rel=1e-6)
        focus_m = expected.lens_at(frame).focus_distance_m
        assert lens.focus_distance_m == pytest.approx(focus_m, rel=1e-6)
    assert path.name in gui.session.messages.text
    gui.do("Undo")
    assert gui.session.facts.shot == before


def test_import_of_a_file_without_a_camera_is_reported(gui, tmp_path):
    path, before = tmp_path / "no.json", gui.session.facts.shot
    path.write_text("{}")
    gui.session.files.commands.cameras.begin(path)
    gui.until(lambda: "no.json" in gui.session.messages.text, "a sentence")
    assert gui.session.facts.shot == before

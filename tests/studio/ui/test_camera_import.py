"""A camera file gives its lens to the shot in the window."""

from dataclasses import replace

import pytest

from heatlens.core.model.curves.frames import FrameRange
from heatlens.core.model.shot.lens_parameter import LensParameter
from heatlens.core.model.shot.shot import Shot
from heatlens.media.camera.camera_file import write_camera
from heatlens.render.source.named import camera_of_shot


def pulled(gui) -> Shot:
    """Return a shot like the window's with another lens, and focus that moves."""
    shot = replace(gui.session.facts.shot, frames=FrameRange(1, 5))
    shot = replace(shot, lens=replace(shot.lens, focal_length_mm=85.0, f_stop=2.0))
    focus = LensParameter.FOCUS_DISTANCE
    return shot.with_key(1, focus, 1.25).with_key(5, focus, 2.5)


@pytest.mark.parametrize("suffix", [".json", ".csv"])
def test_lens_and_keys_are_the_cameras_in_one_step(gui, tmp_path, suffix):
    path, before = tmp_path / f"cam{suffix}", gui.session.facts.shot
    wished = pulled(gui)
    write_camera(path, camera_of_shot(wished, "cam"))
    gui.session.files.commands.cameras.begin(path)
    gui.until(lambda: gui.session.facts.shot != before, "the camera")
    for frame in range(1, 6):
        lens = gui.session.facts.shot.lens_at(frame)
        assert lens.focal_length_mm == pytest.approx(85.0, rel=1e-6)
        assert lens.f_stop == pytest.approx(2.0, rel=1e-6)
        wanted = wished.lens_at(frame).focus_distance_m
        assert lens.focus_distance_m == pytest.approx(wanted, rel=1e-6)
    assert path.name in gui.session.messages.text
    gui.do("Undo")
    assert gui.session.facts.shot == before


def test_what_is_no_camera_is_said_and_changes_nothing(gui, tmp_path):
    path, before = tmp_path / "no.json", gui.session.facts.shot
    path.write_text("{}")
    gui.session.files.commands.cameras.begin(path)
    gui.until(lambda: "no.json" in gui.session.messages.text, "a sentence")
    assert gui.session.facts.shot == before

"""A scene whose file says neither its unit nor which way is up, placed in the window."""

import struct

import numpy as np
import pytest

from heatlens.commands.main import main
from heatlens.documents.shot_file import write_shot
from heatlens.model.framing import WorldAxis
from heatlens.plate.read import read_plate
from heatlens.scene.scene_bounds import bounds_m
from support.gui import gui_of
from support.session_files import QUICK


def stl(path):
    """Return a triangle of 1 x 2 x 3."""
    corners = np.diag((1.0, 2.0, 3.0)).ravel()
    path.write_bytes(bytes(80) + struct.pack("<I12fH", 1, *np.zeros(3), *corners, 0))
    return path


def test_the_scene_panel_places_the_scene_and_undo_takes_it_back(ctx, tmp_path):
    with gui_of(ctx, stl(tmp_path / "a.stl"), defocus=QUICK) as gui:
        session = gui.session
        assert session.scenes.framing.up_axis == "z" and "is taken as up" in session.messages.text
        size = np.ptp(bounds_m(session.source.scene, 1), axis=0)
        np.testing.assert_allclose(size, (1, 3, 2))
        focus_m = session.facts.lens.focus_distance_m
        session.scenes.place(WorldAxis.Y, 0.5)
        gui.settled()
        size = np.ptp(bounds_m(session.source.scene, 1), axis=0)
        np.testing.assert_allclose(size, (0.5, 1, 1.5))
        assert session.pictures.renderer.scene is session.source.scene
        assert session.facts.lens.focus_distance_m == pytest.approx(focus_m / 2)
        depth_m = session.source.plate.depth_m
        assert np.isfinite(depth_m).any() and session.source.plate.depth.far_m < 10
        write_shot(tmp_path / "a.heatlens.json", session.facts.shot)
        session.editing.undo()
        gui.settled()
        np.testing.assert_allclose(np.ptp(bounds_m(session.source.scene, 1), axis=0), (1, 3, 2))
        gui.open(tmp_path / "a.heatlens.json")
        gui.settled()
        assert session.scenes.framing.meters_per_unit == 0.5
        size = np.ptp(bounds_m(session.source.scene, 1), axis=0)
        np.testing.assert_allclose(size, (0.5, 1, 1.5))


def test_the_command_line_places_it_for_a_picture_and_for_a_shot(tmp_path, capsys):
    source, shot = str(stl(tmp_path / "a.stl")), str(tmp_path / "a.heatlens.json")
    words = ["--size", "32x32", "--up-axis", "y", "--meters-per-unit", "cm"]
    assert main(["render", source, "-o", f"{tmp_path}/a.exr", "--pinhole", *words]) == 0
    assert read_plate(tmp_path / "a.exr").depth.far_m < 0.2
    lens = ["--f-stop", "2", "--focus-distance", "5"]
    assert main(["shot", "new", source, "-o", shot, *lens, *words]) == 0
    assert main(["export", shot, "-o", f"{tmp_path}/b.####.exr", "--pinhole"]) == 0
    assert read_plate(tmp_path / "b.0001.exr").depth.far_m < 0.2
    assert "is taken as up" not in capsys.readouterr().err
    with pytest.raises(SystemExit, match="2"):
        main(["render", source, "-o", f"{tmp_path}/c.exr", "--pinhole", "--up-axis", "w"])
    assert "none of x, y and z" in capsys.readouterr().err

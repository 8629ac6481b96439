"""A scene whose file has neither a unit nor an up axis, placed by options of the command line."""

import struct

import numpy as np
import pytest

from heatlens.fronts.commands.main import main
from heatlens.media.plate.read import read_plate


def write_stl(path):
    """Write an STL file with one triangle with corners on the axes at 1, 2 and 3; return it."""
    corners = np.diag((1.0, 2.0, 3.0)).ravel()
    path.write_bytes(bytes(80) + struct.pack("<I12fH", 1, *np.zeros(3), *corners, 0))
    return path


def test_up_axis_and_unit_options_place_a_scene_for_render_and_shot(tmp_path, capsys):
    source, shot = str(write_stl(tmp_path / "a.stl")), str(tmp_path / "a.heatlens.json")
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

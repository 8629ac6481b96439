"""A scene whose file says neither its unit nor which way is up, placed in the window."""

import struct

import numpy as np
import pytest

from heatlens.fronts.commands.main import main
from heatlens.media.plate.read import read_plate


def stl(path):
    """Return a triangle of 1 x 2 x 3."""
    corners = np.diag((1.0, 2.0, 3.0)).ravel()
    path.write_bytes(bytes(80) + struct.pack("<I12fH", 1, *np.zeros(3), *corners, 0))
    return path


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

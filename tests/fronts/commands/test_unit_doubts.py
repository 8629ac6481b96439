"""Test that commands warn of a doubtful depth unit, and that `--strict` refuses the plate."""

import pytest

from heatlens.fronts.commands.main import main
from heatlens.media.plate.plate import depth_span
from heatlens.media.plate.read import read_plate
from support.command_line import stderr_of_run
from support.exr_files import rgb, write_file
from support.plates import room


@pytest.fixture
def in_centimetres(tmp_path):
    """Write a plate of a room whose depth is in centimetres, and return its path."""
    _, depth = room()
    return write_file(tmp_path / "maya.exr", rgb(*depth.shape) | {"Z": 100 * depth})


LENS = ("--focal-length", 50, "--sensor-width", 36, "--f-stop", 2, "--focus-distance", 2)


def test_render_warns_of_doubtful_unit_and_strict_refuses(in_centimetres, tmp_path, capsys):
    words = ["render", in_centimetres, "-o", tmp_path / "out.exr", "--quality", "draft", *LENS]
    assert "--scene-unit cm" in stderr_of_run(capsys, 0, *words)
    assert "--scene-unit" not in stderr_of_run(capsys, 0, *words, "--scene-unit", "cm")
    message = stderr_of_run(capsys, 2, *words, "--strict", "-o", tmp_path / "not.exr")
    assert "maya.exr" in message and "--scene-unit cm" in message
    assert not (tmp_path / "not.exr").exists()


def test_export_warns_of_doubtful_unit_of_plates_and_shots(in_centimetres, tmp_path, capsys):
    shot, out = tmp_path / "s.heatlens.json", tmp_path / "out" / "o.####.exr"
    assert main([str(w) for w in ("shot", "new", in_centimetres, "-o", shot, *LENS)]) == 0
    words = ["export", shot, "-o", out, "--quality", "draft", "--frames", "1"]
    assert "--scene-unit cm" in stderr_of_run(capsys, 0, *words)
    words = ["export", in_centimetres, "-o", out, "--quality", "draft", "--force", *LENS]
    assert "--scene-unit cm" in stderr_of_run(capsys, 0, *words)


def test_info_warns_of_doubtful_depth_range(tmp_path, capsys):
    _, depth = room()
    plate = write_file(tmp_path / "p.exr", rgb(*depth.shape) | {"Z": 100 * depth})
    assert depth_span(read_plate(plate), 1.0).near_m == pytest.approx(90.0)
    assert main(["info", str(plate)]) == 0
    assert "--scene-unit cm" in capsys.readouterr().out

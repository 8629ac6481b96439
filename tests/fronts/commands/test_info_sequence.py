"""`heatlens info` of shots: frames, gaps, sizes, the depth over all of it, and what is wrong."""

import json

import numpy as np
import pytest

from heatlens.fronts.commands.main import main
from support.command_line import stderr_of_run
from support.exr_files import rgb, write_file


def frame_file(folder, frame, near_m=2.0, height=6, width=8):
    depth = np.linspace(near_m, near_m + 5, height * width, dtype="f4").reshape(height, width)
    return write_file(folder / f"s.{frame}.exr", rgb(height, width) | {"Z": depth})


@pytest.fixture
def shot(tmp_path):
    for frame, near_m in ((1001, 3.0), (1002, 1.5), (1005, 4.0)):
        frame_file(tmp_path, frame, near_m)
    return tmp_path


def facts_of(capsys, *words, code=0):
    assert main(["info", *map(str, words), "--json"]) == code
    return json.loads(capsys.readouterr().out)


@pytest.mark.parametrize("name", ["s.####.exr", "s.%04d.exr", ""])
def test_a_pattern_and_a_folder(capsys, shot, name):
    facts = facts_of(capsys, shot / name, code=1)
    assert (facts["frames"], facts["missing"]) == ("1001-1002,1005", "1003-1004")
    assert facts["sizes"] == {"8 x 6": "1001-1002,1005"}
    assert (facts["near_m"], facts["near_frame"]) == (1.5, 1002)
    assert (facts["far_m"], facts["far_frame"]) == (9.0, 1005)


def test_listed_files_are_a_shot_and_others_stand_alone(capsys, shot):
    other = write_file(shot / "still.exr", rgb() | {"Z": np.full((6, 8), 3.0, "f4")})
    facts = facts_of(capsys, shot / "s.1001.exr", shot / "s.1005.exr", other, code=1)
    assert [f["path"] for f in facts] == [str(shot / "s.####.exr"), str(other)]
    assert facts[0]["missing"] == "1002-1004" and facts[1]["depth"]["near_m"] == 3.0
    assert facts_of(capsys, shot / "s.1001.exr")["width_px"] == 8  # one alone is looked at whole


def test_frames_that_differ_or_are_damaged_are_named(capsys, shot):
    frame_file(shot, 1003, height=8)
    (shot / "s.1004.exr").write_bytes(b"no picture")
    assert main(["info", str(shot / "s.####.exr")]) == 1
    said = capsys.readouterr().out
    assert "8 x 6 (frames 1001-1002,1005)" in said and "8 x 8 (frame 1003)" in said
    assert "frame 1004" in said and "is not an OpenEXR file" in said
    assert "1.5 m (frame 1002) to 9 m (frame 1005)" in said


def test_what_several_frames_say_is_said_once(capsys, shot):
    depth = np.full((6, 8), 3.0, "f4")
    for frame in (1001, 1002, 1005):
        write_file(shot / f"s.{frame}.exr", rgb() | {"Z": depth})
    (note,) = facts_of(capsys, shot, code=1)["notes"].items()
    assert note == (
        "depth channel 'Z' is 3 everywhere: the blur will be the same everywhere.",
        "1001-1002,1005",
    )


def test_what_depth_files_say_is_said_once(capsys, shot):
    for frame in (1001, 1002, 1005):
        write_file(shot / f"d.{frame}.exr", {"R": np.full((3, 4), 3.0, "f4")})
    words = (shot / "s.####.exr", "--depth", shot / "d.####.exr")
    (found,) = (it for it in facts_of(capsys, *words, code=1)["notes"].items() if "4 x 3" in it[0])
    assert found[0].startswith("d.####.exr is 4 x 3 pixels") and found[1] == "1001-1002,1005"


def test_the_exit_code_is_that_of_a_check_before_a_farm(capsys, tmp_path):
    """Frames that are missing or cannot be rendered are found; one plate is told as it is."""
    for frame in (1, 2, 3):
        frame_file(tmp_path, frame)
    pattern = str(tmp_path / "s.#.exr")
    assert main(["info", pattern]) == 0
    (tmp_path / "s.2.exr").write_bytes(b"cut")
    assert main(["info", pattern]) == 1
    (tmp_path / "s.2.exr").unlink()
    assert main(["info", pattern]) == 1
    write_file(tmp_path / "s.2.exr", rgb())  # without depth
    assert main(["info", pattern]) == 1
    assert main(["info", str(tmp_path / "s.2.exr")]) == 0
    capsys.readouterr()


def test_a_pattern_without_files(capsys, tmp_path):
    assert "No file is called" in stderr_of_run(capsys, 2, "info", tmp_path / "none.####.exr")

"""Test `heatlens info` of sequences: frames, gaps, sizes, depth range, and faults."""

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
def test_info_of_pattern_or_folder_summarizes_sequence(capsys, shot, name):
    facts = facts_of(capsys, shot / name, code=1)
    assert (facts["frames"], facts["missing"]) == ("1001-1002,1005", "1003-1004")
    assert facts["sizes"] == {"8 x 6": "1001-1002,1005"}
    assert (facts["near_m"], facts["near_frame"]) == (1.5, 1002)
    assert (facts["far_m"], facts["far_frame"]) == (9.0, 1005)


def test_info_groups_listed_files_into_sequence_and_stills(capsys, shot):
    still = write_file(shot / "still.exr", rgb() | {"Z": np.full((6, 8), 3.0, "f4")})
    facts = facts_of(capsys, shot / "s.1001.exr", shot / "s.1005.exr", still, code=1)
    assert [f["path"] for f in facts] == [str(shot / "s.####.exr"), str(still)]
    assert facts[0]["missing"] == "1002-1004" and facts[1]["depth"]["near_m"] == 3.0
    assert facts_of(capsys, shot / "s.1001.exr")["width_px"] == 8  # one alone is looked at whole


def test_info_names_frames_of_other_size_and_damaged_frames(capsys, shot):
    frame_file(shot, 1003, height=8)
    (shot / "s.1004.exr").write_bytes(b"no picture")
    assert main(["info", str(shot / "s.####.exr")]) == 1
    text = capsys.readouterr().out
    assert "8 x 6 (frames 1001-1002,1005)" in text and "8 x 8 (frame 1003)" in text
    assert "frame 1004" in text and "is not an OpenEXR file" in text
    assert "1.5 m (frame 1002) to 9 m (frame 1005)" in text


def test_info_gives_note_of_several_frames_once(capsys, shot):
    depth = np.full((6, 8), 3.0, "f4")
    for frame in (1001, 1002, 1005):
        write_file(shot / f"s.{frame}.exr", rgb() | {"Z": depth})
    (note,) = facts_of(capsys, shot, code=1)["notes"].items()
    assert note == (
        "depth channel 'Z' is 3 everywhere: the blur will be the same everywhere.",
        "1001-1002,1005",
    )


def test_info_gives_note_of_depth_files_once(capsys, shot):
    for frame in (1001, 1002, 1005):
        write_file(shot / f"d.{frame}.exr", {"R": np.full((3, 4), 3.0, "f4")})
    words = (shot / "s.####.exr", "--depth", shot / "d.####.exr")
    (note,) = (
        item for item in facts_of(capsys, *words, code=1)["notes"].items() if "4 x 3" in item[0]
    )
    assert note[0].startswith("d.####.exr is 4 x 3 pixels") and note[1] == "1001-1002,1005"


def test_info_exits_with_1_for_missing_or_unusable_frames(capsys, tmp_path):
    """A sequence with missing or unusable frames gives code 1; a single plate gives code 0."""
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


def test_info_of_pattern_without_files_fails(capsys, tmp_path):
    assert "No file is called" in stderr_of_run(capsys, 2, "info", tmp_path / "none.####.exr")

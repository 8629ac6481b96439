"""The name of one frame: what each command takes it for, and how to mean the others."""

import json

import pytest

from heatlens.fronts.commands.main import main
from support.exports import exported, refused, write_plate, write_plates

LENS = ("--f-stop", "2", "--focus-distance", "2.24", "--quality", "draft")


def said_of(capsys, code: int, *words: object) -> str:
    assert main([str(word) for word in words]) == code
    return capsys.readouterr().err


@pytest.fixture
def frames(tmp_path):
    pattern = write_plates(tmp_path / "in")
    return {"pattern": pattern, "third": pattern.replace("####", "1003")}


def test_one_frame_to_one_picture_is_that_frame(capsys, tmp_path, frames):
    said = exported(capsys, frames["third"], tmp_path / "one.png", *LENS)
    assert "all 6 frames" in said and frames["pattern"] in said
    again = exported(
        capsys, frames["pattern"], tmp_path / "n.png", "--frames", "1003", *LENS, "--overwrite"
    )
    assert "alone" not in again
    first, second = ((tmp_path / name).read_bytes() for name in ("one.png", "n.png"))
    assert first.partition(b"IDAT")[2] == second.partition(b"IDAT")[2]


def test_a_pattern_to_one_picture_is_refused_as_before(capsys, tmp_path, frames):
    assert "single name" in refused(capsys, frames["pattern"], tmp_path / "one.png", *LENS)


def test_one_frame_to_several_files_or_a_movie_is_the_sequence(capsys, tmp_path, frames):
    exported(capsys, frames["third"], tmp_path / "out" / "n.####.exr", *LENS)
    assert len(list((tmp_path / "out").iterdir())) == 6


def test_a_shot_of_one_frame_tells_that_it_has_all(capsys, tmp_path, frames):
    out = tmp_path / "s.heatlens.json"
    said = said_of(capsys, 0, "shot", "new", frames["third"], "-o", out, *LENS)
    assert "1001-1006" in said and "--frames 1003-1003" in said
    said = said_of(capsys, 0, "shot", "new", frames["pattern"], "-o", out, *LENS, "--overwrite")
    assert "one of frames" not in said
    assert json.loads(out.read_text())["source"] == "in/plate.####.exr"


def test_a_frame_of_a_file_is_its_own_or_refused(capsys, tmp_path, frames):
    render = ("render", frames["third"], "-o", tmp_path / "o.png", *LENS, "--frame")
    said_of(capsys, 0, *render, 1003)
    said = said_of(capsys, 2, *render, 1004)
    assert "is frame 1003 alone" in said and frames["pattern"] in said


WRONG = {"still.exr": "leave --frame out", "old.avi": "it reads .mov", "no.exr": "is not there"}


@pytest.mark.parametrize(("name", "expected"), WRONG.items())
def test_a_frame_of_what_has_none_is_told_truly(capsys, tmp_path, name, expected):
    write_plate(tmp_path / "still.exr")
    (tmp_path / "old.avi").write_bytes(b"RIFF")
    words = ("render", tmp_path / name, "-o", tmp_path / "o.png", "--frame", "3", *LENS)
    said = said_of(capsys, 2, *words)
    assert expected in said and "3D scene" not in said


@pytest.mark.parametrize("command", ["export", "render"])
def test_an_unquoted_pattern_is_told_in_one_line(capsys, tmp_path, frames, command):
    files = sorted((tmp_path / "in").iterdir())
    with pytest.raises(SystemExit) as ended:
        main([command, *map(str, files), "-o", str(tmp_path / "n.png")])
    said = capsys.readouterr().err
    assert ended.value.code == 2 and f"quotes, with # for digits: '{frames['pattern']}'" in said
    assert said.count(".exr") == 1

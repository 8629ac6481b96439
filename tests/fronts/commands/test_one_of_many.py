"""Test how commands take the name of one frame: as that frame or as its whole sequence."""

import json

import pytest

from heatlens.fronts.commands.main import main
from support.exports import export_shot, refused_export_message, write_plate, write_plates

LENS = ("--f-stop", "2", "--focus-distance", "2.24", "--quality", "draft")


def message_of_command(capsys, code: int, *words: object) -> str:
    assert main([str(word) for word in words]) == code
    return capsys.readouterr().err


@pytest.fixture
def frames(tmp_path):
    pattern = write_plates(tmp_path / "in")
    return {"pattern": pattern, "third": pattern.replace("####", "1003")}


def test_export_of_one_frame_file_to_one_picture_renders_that_frame(capsys, tmp_path, frames):
    message = export_shot(capsys, frames["third"], tmp_path / "one.png", *LENS)
    assert "all 6 frames" in message and frames["pattern"] in message
    second_message = export_shot(
        capsys, frames["pattern"], tmp_path / "n.png", "--frames", "1003", *LENS, "--overwrite"
    )
    assert "alone" not in second_message
    first, second = ((tmp_path / name).read_bytes() for name in ("one.png", "n.png"))
    assert first.partition(b"IDAT")[2] == second.partition(b"IDAT")[2]


def test_export_of_pattern_to_one_picture_is_refused(capsys, tmp_path, frames):
    assert "single name" in refused_export_message(
        capsys, frames["pattern"], tmp_path / "one.png", *LENS
    )


def test_export_of_one_frame_file_to_pattern_renders_sequence(capsys, tmp_path, frames):
    export_shot(capsys, frames["third"], tmp_path / "out" / "n.####.exr", *LENS)
    assert len(list((tmp_path / "out").iterdir())) == 6


def test_shot_new_of_one_frame_file_uses_sequence_and_says_so(capsys, tmp_path, frames):
    out = tmp_path / "s.heatlens.json"
    message = message_of_command(capsys, 0, "shot", "new", frames["third"], "-o", out, *LENS)
    assert "1001-1006" in message and "--frames 1003-1003" in message
    message = message_of_command(
        capsys, 0, "shot", "new", frames["pattern"], "-o", out, *LENS, "--overwrite"
    )
    assert "one of frames" not in message
    assert json.loads(out.read_text())["source"] == "in/plate.####.exr"


def test_render_frame_option_must_match_frame_of_file(capsys, tmp_path, frames):
    render = ("render", frames["third"], "-o", tmp_path / "o.png", *LENS, "--frame")
    message_of_command(capsys, 0, *render, 1003)
    message = message_of_command(capsys, 2, *render, 1004)
    assert "is frame 1003 alone" in message and frames["pattern"] in message


WRONG = {"still.exr": "leave --frame out", "old.avi": "it reads .mov", "no.exr": "is not there"}


@pytest.mark.parametrize(("name", "expected"), WRONG.items())
def test_render_frame_option_is_refused_for_sources_without_frames(
    capsys, tmp_path, name, expected
):
    write_plate(tmp_path / "still.exr")
    (tmp_path / "old.avi").write_bytes(b"RIFF")
    words = ("render", tmp_path / name, "-o", tmp_path / "o.png", "--frame", "3", *LENS)
    message = message_of_command(capsys, 2, *words)
    assert expected in message and "3D scene" not in message


@pytest.mark.parametrize("command", ["export", "render"])
def test_unquoted_pattern_is_explained_in_message(capsys, tmp_path, frames, command):
    files = sorted((tmp_path / "in").iterdir())
    with pytest.raises(SystemExit) as exit_error:
        main([command, *map(str, files), "-o", str(tmp_path / "n.png")])
    message = capsys.readouterr().err
    assert (
        exit_error.value.code == 2
        and f"quotes, with # for digits: '{frames['pattern']}'" in message
    )
    assert message.count(".exr") == 1

"""A command that cannot do what was typed names the file or the command that is meant."""

from pathlib import Path

import pytest

from heatlens.documents.shot_file import write_shot
from support.command_line import stderr_of_run
from support.exports import shot_of, write_plates
from support.session_files import room_file


@pytest.fixture
def shot(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    write_shot(tmp_path / "pull.heatlens.json", shot_of(write_plates(tmp_path / "plates")))
    return "pull.heatlens.json"


def test_a_shot_is_rendered_by_export(capsys, shot):
    said = stderr_of_run(capsys, 2, "render", shot, "-o", "x.exr")
    assert f"heatlens export {shot}" in said and "--frames" in said


@pytest.mark.parametrize("command", ["camera", "export"])
def test_a_name_without_its_extension_is_completed(capsys, shot, command):
    other = room_file(Path("deep.exr"), 8, 6)
    said = stderr_of_run(capsys, 2, command, "pull", "-o", "x.####.exr")
    assert shot in said and str(other) not in said


def test_a_missing_colour_config_is_named_before_the_format(capsys, tmp_path):
    plate = room_file(tmp_path / "a.exr", 8, 6)
    said = stderr_of_run(capsys, 2, "render", plate, "-o", tmp_path / "b.exr", "--ocio", "no.ocio")
    assert "no.ocio" in said and "does not exist" in said


def test_the_camera_of_one_picture_may_be_asked_for_its_own_frame(capsys, tmp_path):
    plate = room_file(tmp_path / "a.exr", 8, 6)
    words = ("camera", plate, "-o", tmp_path / "cam.json")
    stderr_of_run(capsys, 0, *words, "--frames", "1-1")
    said = stderr_of_run(capsys, 2, *words, "--frames", "1-3")
    assert "--frames 1-3" in said and "1-1" in said

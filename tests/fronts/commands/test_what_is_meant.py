"""A command that cannot do what was typed names the file or the command that is meant."""

import argparse
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from heatlens.fronts.commands import render
from heatlens.fronts.commands.command_parser import meant
from heatlens.fronts.commands.main import main
from heatlens.media.documents.shot_file import write_shot
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


# Options

UNLIKE = {
    "shot sheet s.heatlens.json -o a.html --units ft": "quiet",
    "render p.exr -o a.exr --denoise": "device",
    "view p.exr --frame 3": "first-frame",
}


@pytest.mark.parametrize(("words", "wrong"), UNLIKE.items())
def test_no_option_is_proposed_that_is_not_like_the_typed_one(capsys, words, wrong):
    with pytest.raises(SystemExit):
        main(words.split())
    said = capsys.readouterr().err
    assert "unrecognized" in said and f"--{wrong}" not in said and "Did you mean" not in said


@given(st.data())
def test_one_wrong_letter_proposes_the_option_that_was_meant(data):
    """Two neighbouring letters are swapped in any long option."""
    known = sorted(name.lstrip("-") for name in render_options() if len(name) > 8)
    name = data.draw(st.sampled_from(known))
    at = data.draw(st.integers(1, len(name) - 2))
    typed = f"{name[:at]}{name[at + 1]}{name[at]}{name[at + 2 :]}"
    said = meant([f"--{typed}"], options_parser())
    assert typed in known or f"Did you mean --{name}?" in said


def render_options() -> list[str]:
    return [it for it in options_parser()._option_string_actions if it.startswith("--")]


def options_parser() -> argparse.ArgumentParser:
    own = argparse.ArgumentParser(add_help=False)
    render.add_options(own)
    return own


def test_an_option_of_other_commands_names_them(capsys):
    with pytest.raises(SystemExit):
        main(["view", "p.exr", "--frame", "3"])
    assert "It is an option of `heatlens render`" in capsys.readouterr().err


def test_options_before_the_command_point_to_its_help(capsys):
    with pytest.raises(SystemExit):
        main(["--f-stop", "2", "render", "p.exr"])
    said = capsys.readouterr().err
    assert "options come after the command" in said and "`heatlens render --help`" in said
    assert "view" not in said


def test_a_key_without_a_frame_is_told_so(capsys, tmp_path):
    plate, out = room_file(tmp_path / "a.exr", 8, 6), tmp_path / "s.heatlens.json"
    said = stderr_of_run(capsys, 2, "shot", "new", plate, "-o", out, "--key", "focus=2")
    assert said.endswith("The frame is missing, as in focus@1001=2.")
    said = stderr_of_run(capsys, 2, "shot", "new", plate, "-o", out, "--key", "fokus@3=2")
    assert said.endswith("Did you mean focus?")


# Names of files

READERS = ("render {} -o a.png", "info {}", "export {} -o a.####.png", "compare {} b.exr")


@pytest.mark.parametrize("words", READERS)
@pytest.mark.parametrize("name", ["stil_life", "still_lief", "Still_life"])
def test_a_slip_in_a_file_name_proposes_the_file(capsys, tmp_path, monkeypatch, words, name):
    monkeypatch.chdir(tmp_path)
    room_file(tmp_path / "still_life.exr", 8, 6)
    said = stderr_of_run(capsys, 2, *words.format(f"{name}.exr").split())
    assert "is not there. Did you mean still_life.exr?" in said


FOREIGN = ("[0001-0003]", "*", "{frame:04d}", "<F4>", "????")


@pytest.mark.parametrize("number", FOREIGN)
def test_a_pattern_of_another_program_names_the_frames_that_are_there(capsys, tmp_path, number):
    write_plates(tmp_path / "plates")
    name = str(tmp_path / "plates" / f"plate.{number}.exr")
    said = stderr_of_run(capsys, 2, "export", name, "-o", tmp_path / "a.####.png")
    assert name in said and "plate.####.exr (1001-1006)" in said

"""Test the suggestions of commands for wrong options, commands and file names."""

import argparse
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from heatlens.fronts.commands import render
from heatlens.fronts.commands.main import main
from heatlens.fronts.commands.options.option_suggestion import option_suggestion
from heatlens.media.documents.shot_file import write_shot
from support.command_line import stderr_of_run
from support.exports import shot_of, write_plates
from support.session_files import room_file


@pytest.fixture
def shot(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    write_shot(tmp_path / "pull.heatlens.json", shot_of(write_plates(tmp_path / "plates")))
    return "pull.heatlens.json"


def test_render_of_shot_file_suggests_export(capsys, shot):
    message = stderr_of_run(capsys, 2, "render", shot, "-o", "x.exr")
    assert f"heatlens export {shot}" in message and "--frames" in message


@pytest.mark.parametrize("command", ["camera", "export"])
def test_commands_suggest_file_for_name_without_extension(capsys, shot, command):
    other_file = room_file(Path("deep.exr"), 8, 6)
    message = stderr_of_run(capsys, 2, command, "pull", "-o", "x.####.exr")
    assert shot in message and str(other_file) not in message


def test_render_reports_missing_ocio_config_before_format(capsys, tmp_path):
    plate = room_file(tmp_path / "a.exr", 8, 6)
    message = stderr_of_run(
        capsys, 2, "render", plate, "-o", tmp_path / "b.exr", "--ocio", "no.ocio"
    )
    assert "no.ocio" in message and "does not exist" in message


def test_camera_of_single_picture_accepts_only_its_frame(capsys, tmp_path):
    plate = room_file(tmp_path / "a.exr", 8, 6)
    words = ("camera", plate, "-o", tmp_path / "cam.json")
    stderr_of_run(capsys, 0, *words, "--frames", "1-1")
    message = stderr_of_run(capsys, 2, *words, "--frames", "1-3")
    assert "--frames 1-3" in message and "1-1" in message


# Options

UNLIKE = {
    "shot sheet s.heatlens.json -o a.html --units ft": "quiet",
    "render p.exr -o a.exr --denoise": "device",
    "view p.exr --frame 3": "first-frame",
}


@pytest.mark.parametrize(("words", "wrong"), UNLIKE.items())
def test_unknown_option_gets_no_dissimilar_suggestion(capsys, words, wrong):
    with pytest.raises(SystemExit):
        main(words.split())
    message = capsys.readouterr().err
    assert (
        "unrecognized" in message and f"--{wrong}" not in message and "Did you mean" not in message
    )


@given(st.data())
def test_option_with_swapped_letters_gets_suggestion(data):
    """Swap two neighboring letters of any long option."""
    known_names = sorted(name.lstrip("-") for name in render_options() if len(name) > 8)
    name = data.draw(st.sampled_from(known_names))
    position = data.draw(st.integers(1, len(name) - 2))
    typed = f"{name[:position]}{name[position + 1]}{name[position]}{name[position + 2 :]}"
    message = option_suggestion([f"--{typed}"], options_parser())
    assert typed in known_names or f"Did you mean --{name}?" in message


def render_options() -> list[str]:
    return [it for it in options_parser()._option_string_actions if it.startswith("--")]


def options_parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(add_help=False)
    render.add_options(parser)
    return parser


def test_option_of_other_command_names_that_command(capsys):
    with pytest.raises(SystemExit):
        main(["view", "p.exr", "--frame", "3"])
    assert "It is an option of `heatlens render`" in capsys.readouterr().err


def test_options_before_command_are_explained(capsys):
    with pytest.raises(SystemExit):
        main(["--f-stop", "2", "render", "p.exr"])
    message = capsys.readouterr().err
    assert "options come after the command" in message and "`heatlens render --help`" in message
    assert "view" not in message


def test_key_option_without_frame_is_explained(capsys, tmp_path):
    plate, out = room_file(tmp_path / "a.exr", 8, 6), tmp_path / "s.heatlens.json"
    message = stderr_of_run(capsys, 2, "shot", "new", plate, "-o", out, "--key", "focus=2")
    assert message.endswith("The frame is missing, as in focus@1001=2.")
    message = stderr_of_run(capsys, 2, "shot", "new", plate, "-o", out, "--key", "fokus@3=2")
    assert message.endswith("Did you mean focus?")


# Names of files

READERS = ("render {} -o a.png", "info {}", "export {} -o a.####.png", "compare {} b.exr")


@pytest.mark.parametrize("words", READERS)
@pytest.mark.parametrize("name", ["stil_life", "still_lief", "Still_life"])
def test_misspelt_file_name_gets_suggestion(capsys, tmp_path, monkeypatch, words, name):
    monkeypatch.chdir(tmp_path)
    room_file(tmp_path / "still_life.exr", 8, 6)
    message = stderr_of_run(capsys, 2, *words.format(f"{name}.exr").split())
    assert "is not there. Did you mean still_life.exr?" in message


FOREIGN = ("[0001-0003]", "*", "{frame:04d}", "<F4>", "????")


@pytest.mark.parametrize("number", FOREIGN)
def test_foreign_frame_pattern_names_available_frames(capsys, tmp_path, number):
    write_plates(tmp_path / "plates")
    name = str(tmp_path / "plates" / f"plate.{number}.exr")
    message = stderr_of_run(capsys, 2, "export", name, "-o", tmp_path / "a.####.png")
    assert name in message and "plate.####.exr (1001-1006)" in message

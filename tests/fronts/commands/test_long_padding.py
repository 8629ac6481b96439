"""A padding that would fill the memory is refused in a sentence, wherever a pattern is read."""

import json

import pytest

from heatlens.core.base.errors import InputError
from heatlens.fronts.commands.main import main
from heatlens.media.documents.shot_file import read_shot
from heatlens.media.sequence.names import NameForm, form_of, parse_pattern
from support.command_line import CAMERA, channels
from support.exports import write_shot_file
from support.exr_files import write_file

LONG = "p.%21d.exr"  # some zeros more than a number can need; a file may ask for any number of them
LENS = ("--f-stop", "2", "--focus-distance", "3")


@pytest.mark.parametrize("name", ["p.%4000000000d.exr", "p.$F4000000000.exr", LONG])
def test_a_pattern_of_too_many_digits_is_refused(name):
    with pytest.raises(InputError, match="write at most 20"):
        parse_pattern(name)


def test_twenty_digits_are_a_frame_number_and_more_are_a_name():
    assert parse_pattern("p.%20d.exr") == (NameForm("p.", 20, ".exr"), None)
    assert form_of(f"p.{'1' * 20}.exr") == (NameForm("p.", 20, ".exr"), int("1" * 20))
    for digits in (21, 200, 5000):
        name = f"p.{'1' * digits}.exr"
        assert form_of(name) == (NameForm(name, 0, ""), None)


@pytest.mark.parametrize(
    "words",
    [
        ("info", LONG),
        ("export", LONG, "-o", "o.####.exr", *LENS),
        ("export", "p.1.exr", "-o", LONG, *LENS),
        ("render", LONG, "-o", "o.exr", *LENS),
        ("render", "p.1.exr", "-o", "o.exr", "--depth", LONG, *LENS),
        ("render", "p.1.exr", "-o", "o.exr", "--behind", LONG, *LENS),
        ("camera", LONG, "-o", "c.json"),
        ("shot", "new", LONG, "-o", "n.heatlens.json"),
    ],
)
def test_commands_refuse_it(capsys, tmp_path, monkeypatch, words):
    monkeypatch.chdir(tmp_path)
    write_file(tmp_path / "p.1.exr", channels(), **CAMERA)
    assert main(list(words)) == 2
    said = capsys.readouterr().err
    assert "21 digits: write at most 20" in said and "Traceback" not in said


@pytest.mark.parametrize("place", ["source", "depth_source", "behind"])
def test_shot_files_refuse_it(capsys, tmp_path, place):
    path = write_shot_file(tmp_path)
    told = json.loads(path.read_text())
    read_shot(path)
    at = told if place == "source" else told["plate"]
    at[place] = [LONG] if place == "behind" else LONG
    path.write_text(json.dumps(told))
    assert main(["export", str(path), "-o", str(tmp_path / "o.####.exr")]) == 2
    assert "21 digits: write at most 20" in capsys.readouterr().err

"""Test that a frame padding of too many digits, which would fill the memory, is refused."""

import json

import pytest

from heatlens.core.base.errors import InputError
from heatlens.fronts.commands.main import main
from heatlens.media.documents.shot_file import read_shot
from heatlens.media.sequence.names import NameForm, parse_frame_name, parse_pattern
from support.command_line import CAMERA, channels
from support.exports import write_shot_file
from support.exr_files import write_file

LONG = "p.%21d.exr"  # some zeros more than a number can need; a file may ask for any number of them
LENS = ("--f-stop", "2", "--focus-distance", "3")


@pytest.mark.parametrize("name", ["p.%4000000000d.exr", "p.$F4000000000.exr", LONG])
def test_parse_pattern_rejects_more_than_20_digits(name):
    with pytest.raises(InputError, match="write at most 20"):
        parse_pattern(name)


def test_parse_frame_name_reads_up_to_20_digits_as_frame_number():
    assert parse_pattern("p.%20d.exr") == (NameForm(prefix="p.", padding=20, suffix=".exr"), None)
    assert parse_frame_name(f"p.{'1' * 20}.exr") == (NameForm("p.", 20, ".exr"), int("1" * 20))
    for digits in (21, 200, 5000):
        name = f"p.{'1' * digits}.exr"
        assert parse_frame_name(name) == (NameForm(prefix=name, padding=0, suffix=""), None)


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
def test_commands_reject_too_long_padding(capsys, tmp_path, monkeypatch, words):
    monkeypatch.chdir(tmp_path)
    write_file(tmp_path / "p.1.exr", channels(), **CAMERA)
    assert main(list(words)) == 2
    message = capsys.readouterr().err
    assert "21 digits: write at most 20" in message and "Traceback" not in message


@pytest.mark.parametrize("field", ["source", "depth_source", "behind"])
def test_shot_files_with_too_long_padding_are_rejected(capsys, tmp_path, field):
    path = write_shot_file(tmp_path)
    shot_json = json.loads(path.read_text())
    read_shot(path)
    entry = shot_json if field == "source" else shot_json["plate"]
    entry[field] = [LONG] if field == "behind" else LONG
    path.write_text(json.dumps(shot_json))
    assert main(["export", str(path), "-o", str(tmp_path / "o.####.exr")]) == 2
    assert "21 digits: write at most 20" in capsys.readouterr().err

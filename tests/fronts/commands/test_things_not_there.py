"""Test that every option that names a thing (matte or object id) refuses one that no frame has.

The options are found in the parsers: one that is added is tried too.
"""

import argparse
import json
from collections.abc import Iterator

import numpy as np
import pytest

from heatlens.core.base.errors import InputError
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.fronts.commands.command_parser import build_parser
from heatlens.fronts.commands.main import main
from heatlens.media.plate.exr.exr_read import read_parts
from heatlens.media.plate.read import read_plate
from support.command_line import stderr_of_run
from support.exr_files import write_file
from support.mattes import CARD, HERO, matte_plate

LENS = ("--focal-length", "50", "--sensor-width", "36", "--f-stop", "2", "--focus-distance", "3")
# How each command is called before the option; those with a window are in tests/session.
CALLS = {
    "render": ("{plate}", "-o", "{out}.exr", *LENS),
    "export": ("{plate}", "-o", "{out}.####.exr", *LENS),
    "shot new": ("{plate}", "-o", "{out}.heatlens.json", *LENS),
    "study": ("{plate}", "-o", "{out}", *LENS),
    "camera": ("{plate}", "-o", "{out}.csv", *LENS),
    "bench": ("--drag", "--plate", "{plate}", *LENS),
    "reel": ("{plate}", "-o", "{out}.heatreel.json", "--shots", "{out}", *LENS),
    "info": ("{plate}",),
}
WITH_A_WINDOW = ("view", "serve")


def options_of(parser, words=()) -> Iterator[tuple[str, argparse.Action]]:
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            for name, inner in action.choices.items():
                yield from options_of(inner, (*words, name))
        elif action.option_strings and "cryptomatte:" in f"{action.help} {action.metavar}".replace(
            "MATTE", "cryptomatte:"
        ):
            yield " ".join(words), action


OPTIONS_NAMING_A_THING = sorted(
    {(command, action.option_strings[0]) for command, action in options_of(build_parser())}
)
TESTED_OPTIONS = [pair for pair in OPTIONS_NAMING_A_THING if pair[0] not in WITH_A_WINDOW]


def value_for(option, thing):
    return f"A={thing}" if option in ("--mark", "--follow") else thing


def command_line(folder, command, option, thing, plate="p.1001.exr"):
    paths = {"plate": str(folder / plate), "out": str(folder / "made")}
    words = [word.format(**paths) for word in CALLS[command]]
    if option == "--follow":  # which gives the focus itself
        words = words[: words.index("--focus-distance")]
    return [*command.split(), *words, option, value_for(option, thing)]


@pytest.fixture
def folder(tmp_path):
    """Return a folder with two frames; `hero` is only in the second and in its manifest."""
    manifest = f'{{"card": "{CARD:08x}"}}'
    matte_plate(tmp_path / "p.1001.exr", None, manifest=manifest)
    matte_plate(tmp_path / "p.1002.exr", 3.0)
    return tmp_path


def test_parsers_have_options_that_name_a_thing():
    options = {option for _, option in OPTIONS_NAMING_A_THING}
    assert options >= {"--never-blur", "--only-blur", "--flat-depth", "--mark", "--follow"}


@pytest.mark.parametrize(("command", "option"), TESTED_OPTIONS)
def test_options_reject_misspelt_thing_with_suggestion(folder, capsys, command, option):
    message = stderr_of_run(capsys, 2, *command_line(folder, command, option, "cryptomatte:crad"))
    assert "Did you mean card?" in message and "p.1001.exr" in message
    assert not list(folder.glob("made*.*")) and not list(folder.glob("made/*"))


@pytest.mark.parametrize(("command", "option"), TESTED_OPTIONS)
def test_options_reject_object_id_without_pixels(folder, capsys, command, option):
    message = stderr_of_run(capsys, 2, *command_line(folder, command, option, "objectId:99"))
    assert "no pixel of objectId is 99" in message


@pytest.mark.parametrize("option", ["--never-blur", "--only-blur", "--flat-depth", "--mark"])
@pytest.mark.parametrize("thing", ["cryptomatte:hero", "objectId:7"])
def test_options_accept_thing_that_only_other_frame_has(folder, option, thing):
    command = "shot new" if option == "--mark" else "render"
    assert main(command_line(folder, command, option, thing)) == 0


@pytest.mark.parametrize(("command", "option"), TESTED_OPTIONS)
def test_options_reject_cryptomatte_stored_as_half(tmp_path, capsys, command, option):
    half_plate(tmp_path / "p.1001.exr")
    message = stderr_of_run(capsys, 2, *command_line(tmp_path, command, option, "cryptomatte:hero"))
    assert "stored as half" in message


def half_plate(path):
    ((header, planes),) = read_parts(matte_plate(path, 3.0))
    manifest_entries = {name: header[name] for name in header if name.startswith("cryptomatte/")}
    with np.errstate(over="ignore", invalid="ignore"):
        halves = {
            name: plane.astype("f2") if name.startswith("Crypto") else plane
            for name, plane in planes.items()
        }
    return write_file(path, halves, **manifest_entries)


@pytest.mark.parametrize("name", [f"{HERO:08x}", f"#{HERO:08x}", f"0x{HERO:08X}", "hero"])
def test_cryptomatte_without_manifest_is_found_by_hash(tmp_path, name):
    path = matte_plate(tmp_path / "p.exr", 3.0, manifest="{}")
    options = PlateOptions(never_blur=f"cryptomatte:{name}")
    cutout = read_plate(path, options).cutout
    assert cutout is not None and cutout.share.sum() == 64
    with pytest.raises(InputError, match="manifest"):
        read_plate(path, PlateOptions(never_blur="cryptomatte:nobody"))


@pytest.mark.parametrize(("command", "option"), TESTED_OPTIONS)
def test_cryptomatte_number_is_taken_as_name(folder, capsys, command, option):
    message = stderr_of_run(capsys, 2, *command_line(folder, command, option, "cryptomatte:12"))
    assert "no Cryptomatte has '12'" in message


def test_info_lists_names_of_cryptomatte_things(folder, capsys):
    for words, expected in (
        (("info", folder / "p.1002.exr"), "card, hero"),
        (("info", folder), "hero"),
    ):
        assert main([str(word) for word in words]) == 0
        text = capsys.readouterr().out
        assert "2 in Crypto" in text and expected in text
    names = {f"thing {number:02}": f"{number + 0x11000000:08x}" for number in range(25)}
    many_things_plate = matte_plate(folder / "many.exr", 3.0, manifest=json.dumps(names))
    assert main(["info", str(many_things_plate)]) == 0
    text = capsys.readouterr().out
    assert "25 in Crypto" in text and "thing 19 and 5 more" in text and "thing 20" not in text
    assert main(["info", "--json", str(many_things_plate)]) == 0
    assert json.loads(capsys.readouterr().out)["things"] == {"Crypto": sorted(names)}

"""An output that cannot be written is told before a command begins, by every command alike."""

import argparse
import os
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

from heatlens.core.base.errors import InputError
from heatlens.fronts.commands.command_parser import build_parser
from heatlens.fronts.commands.main import main
from heatlens.fronts.commands.options.before_running import OUTPUTS
from heatlens.media.files.atomic_file import check_place

NOWHERE = Path("/proc/heatlens")  # nobody can make a file there, root neither
_WRITES = re.compile(
    r"\bto write\b|^(also )?write |write (the|a|the cut|the hidden) ", re.IGNORECASE
)
# Options that write into the output of another option, or speak of writing alone.
_OTHERS = {"pinhole", "burn_in", "with_depth", "with_coc", "overwrite", "progress"}
COMMANDS = {
    "render p.exr": ["output", "behind_out"],
    "export p.exr": ["output"],
    "export c.otio -o {shot}.####.exr": ["edit_out"],
    "export p.exr -o n.####.exr --submit openjd": ["bundle"],
    "study p.exr": ["output"],
    "compare a.exr b.exr": ["difference"],
    "bench --methods": ["plot"],
    "camera s.heatlens.json": ["output"],
    "shot new p.exr": ["output"],
    "shot sheet s.heatlens.json": ["output"],
    "shot size s.heatlens.json A --by length": ["output"],
    "reel c.otio": ["output"],
    "reel c.otio -o r.heatreel.json": ["shots"],
}
ENDINGS = {"export": "n.####.exr", "render": "n.exr", "bench": "n.svg", "compare": "n.png"}


def options_of(parser: argparse.ArgumentParser, name: str) -> Iterator[tuple[str, argparse.Action]]:
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            for own, inner in action.choices.items():
                yield from options_of(inner, f"{name} {own}".strip())
        elif action.option_strings:
            yield name, action


def test_every_option_that_names_an_output_is_looked_at():
    wrong = {
        f"{command} {action.option_strings[0]}"
        for command, action in options_of(build_parser(), "")
        if (action.dest in ("output",) or _WRITES.search(action.help or ""))
        and action.nargs != 0
        and action.dest not in (*OUTPUTS, *_OTHERS)
    }
    assert not wrong


def test_the_commands_below_are_all_that_have_an_output():
    found = {
        (command, action.dest)
        for command, action in options_of(build_parser(), "")
        if action.dest in OUTPUTS and action.metavar != "N"
    }
    tried = {
        (" ".join(words.split()[: 2 if words.startswith("shot") else 1]), name)
        for words, names in COMMANDS.items()
        for name in names
    }
    assert found == tried


@pytest.mark.skipif(not NOWHERE.parent.is_dir(), reason="this system has no /proc")
@pytest.mark.parametrize(
    ("words", "name"), [(words, name) for words, names in COMMANDS.items() for name in names]
)
def test_no_command_begins_without_a_place_to_write(capsys, monkeypatch, tmp_path, words, name):
    monkeypatch.chdir(tmp_path)
    command = words.split()[0]
    where = NOWHERE / ENDINGS.get(command, "n.heatlens.json")
    needed = (
        [] if name == "output" or " -o " in words or command not in ("render",) else ["-o", "o.exr"]
    )
    option = "--" + name.replace("_", "-")
    assert main([*words.split(), *needed, f"{option}={where}"]) == 2
    said = capsys.readouterr().err
    assert said.startswith(f"heatlens: {where}: no file can be made in /proc")
    assert len(said.splitlines()) == 1 and os.listdir(tmp_path) == []


@pytest.mark.parametrize("missing", ["o.exr", "a/o.exr", "a/b/c/o.exr"])
def test_a_place_that_can_be_written_is_left_as_it_was(tmp_path, missing):
    check_place(tmp_path / missing)
    assert os.listdir(tmp_path) == []


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write everywhere")
def test_a_folder_without_rights_is_told(tmp_path):
    barred = tmp_path / "barred"
    barred.mkdir(mode=0o500)
    with pytest.raises(InputError, match="is not writable"):
        check_place(barred / "a" / "o.exr")

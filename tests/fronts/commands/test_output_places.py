"""Test that every command refuses an unwritable output before it begins."""

import argparse
import os
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

from heatlens.core.base.errors import InputError
from heatlens.fronts.commands.command_parser import build_parser
from heatlens.fronts.commands.main import main
from heatlens.fronts.commands.options.before_running import OUTPUT_OPTIONS
from heatlens.media.files.atomic_file import check_output_path

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
    "addon build": ["output"],
    "report": ["output"],
    "shot new p.exr": ["output"],
    "shot sheet s.heatlens.json": ["output"],
    "shot size s.heatlens.json A --by length": ["output"],
    "reel c.otio": ["output"],
    "reel c.otio -o r.heatreel.json": ["shots"],
}
ENDINGS = {
    "addon": "n.zip",
    "report": "n.zip",
    "export": "n.####.exr",
    "render": "n.exr",
    "bench": "n.svg",
    "compare": "n.png",
}


def options_of(parser: argparse.ArgumentParser, name: str) -> Iterator[tuple[str, argparse.Action]]:
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            for command_word, inner in action.choices.items():
                yield from options_of(inner, f"{name} {command_word}".strip())
        elif action.option_strings:
            yield name, action


def test_every_output_option_is_in_list_of_outputs():
    wrong = {
        f"{command} {action.option_strings[0]}"
        for command, action in options_of(build_parser(), "")
        if (action.dest in ("output",) or _WRITES.search(action.help or ""))
        and action.nargs != 0
        and action.dest not in (*OUTPUT_OPTIONS, *_OTHERS)
    }
    assert not wrong


def test_commands_of_this_file_cover_all_output_options():
    parser_outputs = {
        (command, action.dest)
        for command, action in options_of(build_parser(), "")
        if action.dest in OUTPUT_OPTIONS and action.metavar != "N"
    }
    tested_outputs = {
        (" ".join(words.split()[: 2 if words.startswith("shot") else 1]), name)
        for words, names in COMMANDS.items()
        for name in names
    }
    assert parser_outputs == tested_outputs


@pytest.mark.skipif(not NOWHERE.parent.is_dir(), reason="this system has no /proc")
@pytest.mark.parametrize(
    ("words", "name"), [(words, name) for words, names in COMMANDS.items() for name in names]
)
def test_commands_reject_unwritable_output_before_work(capsys, monkeypatch, tmp_path, words, name):
    monkeypatch.chdir(tmp_path)
    command = words.split()[0]
    output_path = NOWHERE / ENDINGS.get(command, "n.heatlens.json")
    required_options = (
        [] if name == "output" or " -o " in words or command not in ("render",) else ["-o", "o.exr"]
    )
    option = "--" + name.replace("_", "-")
    assert main([*words.split(), *required_options, f"{option}={output_path}"]) == 2
    message = capsys.readouterr().err
    assert message.startswith(f"heatlens: {output_path}: no file can be made in /proc")
    assert len(message.splitlines()) == 1 and os.listdir(tmp_path) == []


@pytest.mark.parametrize("missing", ["o.exr", "a/o.exr", "a/b/c/o.exr"])
def test_check_output_path_leaves_no_files_at_writable_path(tmp_path, missing):
    check_output_path(tmp_path / missing)
    assert os.listdir(tmp_path) == []


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write everywhere")
def test_check_output_path_rejects_folder_without_write_permission(tmp_path):
    barred = tmp_path / "barred"
    barred.mkdir(mode=0o500)
    with pytest.raises(InputError, match="is not writable"):
        check_output_path(barred / "a" / "o.exr")

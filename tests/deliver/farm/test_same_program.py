"""Test warnings of other versions, drivers and devices, which `--strict` makes refusals."""

import os
import subprocess

import pytest
import yaml

from deliver.farm.test_bundle import QUICK
from deliver.farm.test_openjd import arguments
from heatlens.core.base.errors import InputError
from heatlens.deliver.farm.answers import PartDone
from heatlens.deliver.farm.cluster import ClusterMaker, PartTask
from heatlens.fronts.commands.main import main
from heatlens.version import __version__
from support.dask_cluster import HEATLENS
from support.exports import export_shot, files_in, refused_export_message
from support.patience import PATIENCE_S

# What the job was written by (version/driver), and a word of the message on the difference.
OTHERS = [("9.9", "heatlens"), (f"{__version__}/GeForce 9", "graphics driver"), ("9.9/x", "and")]


def test_submitted_job_expects_version_and_driver(capsys, shot_file, tmp_path, session_context):
    words = ("-o", str(tmp_path / "m.mov"), "--submit", "openjd", "--strict", *QUICK)
    assert main(["export", str(shot_file), *words]) == 0
    text = capsys.readouterr().out
    expected = f"--expect={__version__}/{session_context.name}"
    assert expected in arguments(text) and "--strict" in arguments(text)
    assert expected in yaml.safe_load(text)["steps"][-1]["script"]["actions"]["onRun"]["args"]


def test_job_for_gpus_expects_version_but_no_driver(capsys, shot_file, tmp_path):
    """This machine renders in software, but the nodes with a GPU have another driver."""
    words = ("-o", str(tmp_path / "n.####.exr"), "--submit", "openjd", "--strict", *QUICK)
    assert main(["export", str(shot_file), *words, "--gpus", "1"]) == 0
    assert f"--expect={__version__}" in arguments(capsys.readouterr().out)


@pytest.mark.parametrize(("expected_program", "word"), OTHERS)
def test_export_warns_of_other_program_and_strict_refuses(
    capsys, shot_file, tmp_path, expected_program, word
):
    out = tmp_path / "out" / "n.####.exr"
    message = refused_export_message(
        capsys, shot_file, out, "--expect", expected_program, "--strict"
    )
    assert word in message and "the job was written" in message
    assert files_in(out.parent) == {}
    assert "the job was written" in export_shot(
        capsys, shot_file, out, "--expect", expected_program
    )
    assert len(files_in(out.parent)) == 6


def test_export_by_expected_program_gives_no_warning(capsys, shot_file, tmp_path, session_context):
    this_program = f"{__version__}/{session_context.name}"
    message = export_shot(
        capsys,
        shot_file,
        tmp_path / "n.####.exr",
        "--frames",
        1001,
        "--expect",
        this_program,
        "--strict",
    )
    assert "the job was written" not in message


@pytest.mark.parametrize("strict", [False, True])
def test_cluster_names_workers_with_different_drivers(strict):
    messages: list[str] = []
    maker = ClusterMaker(
        None, lambda task: b"", PartTask((), "", "", fetch=False, topic=""), 1, messages.append
    )
    maker._strict = strict
    maker._compare_driver(
        PartDone(1, was_there=False, surfaces_lost="", remarks=(), driver=("software", "tcp://a"))
    )
    maker._compare_driver(PartDone(2, was_there=True, surfaces_lost="", remarks=()))
    maker._compare_driver(
        PartDone(3, was_there=False, surfaces_lost="", remarks=(), driver=("software", "tcp://b"))
    )
    assert not messages
    if strict:
        with pytest.raises(InputError, match=r"software \(tcp://a\), GPU \(tcp://c\)"):
            maker._compare_driver(
                PartDone(
                    4, was_there=False, surfaces_lost="", remarks=(), driver=("GPU", "tcp://c")
                )
            )
        return
    for _ in range(2):
        maker._compare_driver(
            PartDone(4, was_there=False, surfaces_lost="", remarks=(), driver=("GPU", "tcp://c"))
        )
    assert len(messages) == 1 and "software (tcp://a), GPU (tcp://c)" in messages[0]


def run_export(*words: object) -> "subprocess.CompletedProcess[str]":
    return run_words("export", *words)


def run_words(*words: object) -> "subprocess.CompletedProcess[str]":
    line = [*HEATLENS, *map(str, words)]
    return subprocess.run(line, capture_output=True, text=True, check=False, timeout=PATIENCE_S)


def test_device_option_applies_to_all_processes(capsys, shot_file, tmp_path):
    """Both processes use the first device (`0,0`) and write the same files."""
    export_shot(capsys, shot_file, tmp_path / "whole" / "n.####.exr")
    out = tmp_path / "out" / "n.####.exr"
    process = run_export(shot_file, "-o", out, "--device", "0,0", "--processes", 2)
    assert process.returncode == 0, process.stderr
    assert files_in(tmp_path / "out") == files_in(tmp_path / "whole")


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (("--device", "99"), "--device counts the devices of EGL from 0"),
        (("--device", "-1"), "--device counts from 0"),
        (("--device", "0,99", "--processes", "2"), "--device counts the devices of EGL from 0"),
        (("--device", "0,1"), "--processes"),
        (("--device", "x"), "not a whole number"),
    ],
)
def test_export_rejects_missing_device(shot_file, tmp_path, words, expected):
    process = run_export(shot_file, "-o", tmp_path / "n.####.exr", *words)
    assert (
        process.returncode == 2 and expected in process.stderr and "Traceback" not in process.stderr
    )
    assert not list(tmp_path.glob(".heatlens-*"))
    assert "GLCONTEXT_DEVICE_INDEX" not in os.environ


@pytest.mark.parametrize("command", ["render", "study", "bench", "serve"])
def test_windowless_commands_accept_device_option(tmp_path, command):
    """With a device number that no machine has, each command fails before it works."""
    words = {
        "render": ("demo", "-o", tmp_path / "a.exr"),
        "study": ("demo", "-o", tmp_path / "r"),
        "serve": ("--address", "127.0.0.1:0"),  # whatever else serves on this machine
    }
    process = run_words(command, *words.get(command, ()), "--device", "99")
    assert process.returncode == 2 and "--device counts the devices of EGL from 0" in process.stderr
    process = run_words(command, *words.get(command, ()), "--device", "0,1")
    assert process.returncode == 2 and "--device names 2 devices: give one." in process.stderr

"""Other versions, drivers and devices: said, and refused with `--strict`."""

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
from support.exports import exported, files_in, refused

OTHERS = [("9.9", "heatlens"), (f"{__version__}/GeForce 9", "OpenGL driver"), ("9.9/x", "and")]


def test_a_job_tells_its_version_and_driver(capsys, shot_file, tmp_path, session_context):
    words = ("-o", str(tmp_path / "m.mov"), "--submit", "openjd", "--strict", *QUICK)
    assert main(["export", str(shot_file), *words]) == 0
    text = capsys.readouterr().out
    expected = f"--expect={__version__}/{session_context.name}"
    assert expected in arguments(text) and "--strict" in arguments(text)
    assert expected in yaml.safe_load(text)["steps"][-1]["script"]["actions"]["onRun"]["args"]


def test_a_job_for_gpus_expects_no_driver_of_a_login_node(capsys, shot_file, tmp_path):
    """This machine draws in software; the nodes with a GPU have another driver, even if strict."""
    words = ("-o", str(tmp_path / "n.####.exr"), "--submit", "openjd", "--strict", *QUICK)
    assert main(["export", str(shot_file), *words, "--gpus", "1"]) == 0
    assert f"--expect={__version__}" in arguments(capsys.readouterr().out)


@pytest.mark.parametrize(("wanted", "named"), OTHERS)
def test_another_program_is_said_and_refused_with_strict(
    capsys, shot_file, tmp_path, wanted, named
):
    out = tmp_path / "out" / "n.####.exr"
    said = refused(capsys, shot_file, out, "--expect", wanted, "--strict")
    assert named in said and "the job was written" in said
    assert files_in(out.parent) == {}
    assert "the job was written" in exported(capsys, shot_file, out, "--expect", wanted)
    assert len(files_in(out.parent)) == 6


def test_the_same_program_is_not_told(capsys, shot_file, tmp_path, session_context):
    here = f"{__version__}/{session_context.name}"
    said = exported(
        capsys, shot_file, tmp_path / "n.####.exr", "--frames", 1001, "--expect", here, "--strict"
    )
    assert "the job was written" not in said


@pytest.mark.parametrize("strict", [False, True])
def test_workers_with_different_drivers_are_named(strict):
    told: list[str] = []
    maker = ClusterMaker(None, lambda task: b"", PartTask((), "", "", False, ""), 1, told.append)
    maker._strict = strict
    maker._compare(PartDone(1, False, "", (), ("software", "tcp://a")))
    maker._compare(PartDone(2, True, "", ()))
    maker._compare(PartDone(3, False, "", (), ("software", "tcp://b")))
    assert not told
    if strict:
        with pytest.raises(InputError, match=r"software \(tcp://a\), GPU \(tcp://c\)"):
            maker._compare(PartDone(4, False, "", (), ("GPU", "tcp://c")))
        return
    for _ in range(2):
        maker._compare(PartDone(4, False, "", (), ("GPU", "tcp://c")))
    assert len(told) == 1 and "software (tcp://a), GPU (tcp://c)" in told[0]


def run(*words: object) -> "subprocess.CompletedProcess[str]":
    return run_words("export", *words)


def run_words(*words: object) -> "subprocess.CompletedProcess[str]":
    line = [*HEATLENS, *map(str, words)]
    return subprocess.run(line, capture_output=True, text=True, check=False, timeout=120)


def test_a_device_is_chosen_for_all_processes(capsys, shot_file, tmp_path):
    """The first device of this machine makes the same files, in turn with itself."""
    exported(capsys, shot_file, tmp_path / "whole" / "n.####.exr")
    out = tmp_path / "out" / "n.####.exr"
    done = run(shot_file, "-o", out, "--device", "0,0", "--processes", 2)
    assert done.returncode == 0, done.stderr
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
def test_a_device_that_is_not_there(shot_file, tmp_path, words, expected):
    done = run(shot_file, "-o", tmp_path / "n.####.exr", *words)
    assert done.returncode == 2 and expected in done.stderr and "Traceback" not in done.stderr
    assert not list(tmp_path.glob(".heatlens-*"))
    assert "GLCONTEXT_DEVICE_INDEX" not in os.environ


@pytest.mark.parametrize("command", ["render", "study", "bench", "serve"])
def test_every_command_without_a_window_takes_a_device(tmp_path, command):
    """With a number that no machine has, each says so before it works."""
    words = {
        "render": ("demo", "-o", tmp_path / "a.exr"),
        "study": ("demo", "-o", tmp_path / "r"),
        "serve": ("--address", "127.0.0.1:0"),  # whatever else serves on this machine
    }
    done = run_words(command, *words.get(command, ()), "--device", "99")
    assert done.returncode == 2 and "--device counts the devices of EGL from 0" in done.stderr
    done = run_words(command, *words.get(command, ()), "--device", "0,1")
    assert done.returncode == 2 and "--device names 2 devices: give one." in done.stderr

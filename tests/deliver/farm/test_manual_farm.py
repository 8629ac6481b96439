"""The commands that the manual shows for several machines, each block as one types it."""

import os
import re
import subprocess
from pathlib import Path

import distributed
import pytest

from heatlens.media.documents.shot_file import write_shot
from support.exports import exported, files_in, shot_of, write_plates
from support.slurm import BIN, Slurm, free_ports, why_not

MANUAL = Path(__file__).parents[3] / "app" / "MANUAL.md"
SCRIPTS = Path(distributed.__file__).parents[4] / "bin"  # of the packages, where they are elsewhere


def blocks() -> dict[str, str]:
    """Return the blocks by the folder that they write to."""
    text = MANUAL.read_text().partition("### Beyond one machine")[2].partition("\n### ")[0]
    found = re.findall(r"```shell\n(.*?)```", text, re.DOTALL)
    return {re.search(r"-o '?(\w+)/", block)[1]: block for block in found}


@pytest.fixture
def folder(tmp_path) -> Path:
    source = write_plates(tmp_path / "plates")
    write_shot(tmp_path / "pull.heatlens.json", shot_of(source))
    return tmp_path


def run(block: str, folder: Path, environment: dict[str, str]) -> None:
    paths = os.pathsep.join([str(BIN), str(SCRIPTS), environment["PATH"]])
    done = subprocess.run(
        ["bash", "-em"], input=block, text=True, cwd=folder, env=environment | {"PATH": paths},
        capture_output=True, check=False, timeout=120,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr


def check(capsys, folder: Path, name: str) -> None:
    """Compare with what one process makes."""
    kinds = {path.name for path in (folder / name).iterdir()}
    for output in ("pull.mp4", "pull.####.exr"):
        if any(kind.endswith(output[-4:]) for kind in kinds):
            exported(capsys, folder / "pull.heatlens.json", folder / "whole" / output)
    assert files_in(folder / name) == files_in(folder / "whole")


@pytest.mark.parametrize("name", ["processes", "cluster", "farm", "bundle"])
def test_the_commands_of_the_manual_do_what_it_says(capsys, folder, name):
    port = str(free_ports(1)[0])
    run(blocks()[name].replace("8786", port), folder, dict(os.environ))
    check(capsys, folder, name)


@pytest.mark.skipif(bool(why_not()), reason=why_not() or "a Slurm can be started")
def test_the_commands_for_slurm_do_what_it_says(capsys, folder):
    (folder / "here").mkdir()
    slurm = Slurm(folder / "here")
    try:
        slurm.start()
        run(blocks()["slurm"], folder, slurm.environment)
        slurm.drained()
    finally:
        slurm.stop()
    check(capsys, folder, "slurm")


def test_every_way_is_shown():
    assert set(blocks()) == {"processes", "cluster", "slurm", "farm", "bundle"}

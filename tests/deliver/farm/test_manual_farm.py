"""Run the commands that the manual shows for several machines, block by block."""

import os
import re
import subprocess
from pathlib import Path

import distributed
import pytest

from heatlens.media.documents.shot_file import write_shot
from support.exports import export_shot, files_in, shot_of, write_plates
from support.manual import page
from support.patience import PATIENCE_S
from support.slurm import BIN, Slurm, free_ports, why_no_slurm

SCRIPTS = Path(distributed.__file__).parents[4] / "bin"  # of the packages, where they are elsewhere


def manual_blocks() -> dict[str, str]:
    """Return the shell blocks of the manual by the folder that they write to."""
    shell_blocks = re.findall(r"```shell\n(.*?)```", page("farm"), re.DOTALL)
    return {re.search(r"-o '?(\w+)/", block)[1]: block for block in shell_blocks}


@pytest.fixture
def folder(tmp_path) -> Path:
    source = write_plates(tmp_path / "plates")
    write_shot(tmp_path / "pull.heatlens.json", shot_of(source))
    return tmp_path


def run_block(block: str, folder: Path, environment: dict[str, str]) -> None:
    paths = os.pathsep.join([str(BIN), str(SCRIPTS), environment["PATH"]])
    process = subprocess.run(
        ["bash", "-em"], input=block, text=True, cwd=folder, env=environment | {"PATH": paths},
        capture_output=True, check=False, timeout=PATIENCE_S,
    )  # fmt: skip
    assert process.returncode == 0, process.stdout + process.stderr


def check_against_one_process(capsys, folder: Path, name: str) -> None:
    """Check that the files in `name` equal those that one process exports."""
    kinds = {path.name for path in (folder / name).iterdir()}
    for output in ("pull.mp4", "pull.####.exr"):
        if any(kind.endswith(output[-4:]) for kind in kinds):
            export_shot(capsys, folder / "pull.heatlens.json", folder / "whole" / output)
    assert files_in(folder / name) == files_in(folder / "whole")


@pytest.mark.parametrize("name", ["processes", "cluster", "farm", "bundle"])
def test_farm_commands_of_manual_work_as_shown(capsys, folder, name):
    port = str(free_ports(1)[0])
    run_block(manual_blocks()[name].replace("8786", port), folder, dict(os.environ))
    check_against_one_process(capsys, folder, name)


@pytest.mark.skipif(bool(why_no_slurm()), reason=why_no_slurm() or "a Slurm can be started")
def test_slurm_commands_of_manual_work_as_shown(capsys, folder):
    (folder / "here").mkdir()
    slurm = Slurm(folder / "here")
    try:
        slurm.start()
        run_block(manual_blocks()["slurm"], folder, slurm.environment)
        slurm.drained()
    finally:
        slurm.stop()
    check_against_one_process(capsys, folder, "slurm")


def test_manual_shows_every_kind_of_farm():
    assert set(manual_blocks()) == {"processes", "cluster", "slurm", "farm", "bundle"}

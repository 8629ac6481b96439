"""What stands in the root of the repository, so that nothing is left there by a run."""

import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
FILES = {".gitignore", ".pre-commit-config.yaml", "LICENSE", "README.md", "pyproject.toml"}
FOLDERS = {".ci", "app", "assets", "shaders", "tests"}


def tracked() -> list[str]:
    told = subprocess.run(
        ["git", "ls-files"], cwd=ROOT, capture_output=True, text=True, check=False
    )
    if told.returncode:
        pytest.skip("this is no checkout of git")
    return told.stdout.splitlines()


def test_the_root_holds_what_belongs_there():
    names = {name.partition("/")[0] for name in tracked()}
    assert names == FILES | FOLDERS


def test_no_log_of_a_run_is_tracked():
    assert not [name for name in tracked() if name.endswith((".out", ".log", ".part", ".orig"))]

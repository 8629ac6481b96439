"""Test that the root of the repository holds only known files, and no leftovers of a run."""

import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
FILES = {".gitignore", ".pre-commit-config.yaml", "CITATION.cff", "LICENSE", "README.md"}
FILES |= {"pyproject.toml"}
FOLDERS = {".ci", ".github", "app", "assets", "shaders", "tests"}


def tracked_files() -> list[str]:
    process = subprocess.run(
        ["git", "ls-files"], cwd=ROOT, capture_output=True, text=True, check=False
    )
    if process.returncode:
        pytest.skip("this is no checkout of git")
    return process.stdout.splitlines()


def test_root_holds_only_known_files_and_folders():
    names = {name.partition("/")[0] for name in tracked_files()}
    assert names == FILES | FOLDERS


def test_no_log_of_a_run_is_tracked():
    assert not [
        name for name in tracked_files() if name.endswith((".out", ".log", ".part", ".orig"))
    ]

"""The tests of the model run where no library for OpenGL or windows is installed."""

import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
CODE = """
import sys
import pytest
for name in ("moderngl", "glcontext", "glfw", "imgui_bundle"):
    sys.modules[name] = None  # makes each import of it fail
sys.exit(pytest.main(sys.argv[1:]))
"""


def run_tests(*words: str) -> subprocess.CompletedProcess[str]:
    """Run pytest in a process that has none of these libraries."""
    command = [sys.executable, "-c", CODE, "-q", "-p", "no:cacheprovider", *words]
    return subprocess.run(command, cwd=ROOT, capture_output=True, text=True)


def test_every_test_of_the_model_can_be_collected():
    run = run_tests("--collect-only", "tests/core/model")
    assert run.returncode == 0, run.stdout


def test_a_test_of_the_model_runs():
    run = run_tests("tests/core/model/test_boxes.py")
    assert run.returncode == 0, run.stdout


def test_a_test_that_draws_does_not():
    """Otherwise the two tests above would prove nothing."""
    assert run_tests("tests/render/display/test_display_pass.py").returncode != 0

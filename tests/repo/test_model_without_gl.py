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


def test_model_tests_can_be_collected_without_gl():
    run = run_tests("--collect-only", "tests/core/model")
    assert run.returncode == 0, run.stdout


def test_model_test_runs_without_gl():
    run = run_tests("tests/core/model/test_boxes.py")
    assert run.returncode == 0, run.stdout


def test_drawing_test_fails_without_gl():
    """This shows that the two tests above really run without the libraries."""
    assert run_tests("tests/render/display/test_display_pass.py").returncode != 0

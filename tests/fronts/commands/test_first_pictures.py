"""Test `heatlens` without a display: it writes pictures and suggests further commands."""

import shlex
import shutil
import subprocess
import sys

import numpy as np
from PIL import Image

from heatlens.core.base.errors import NoWindowError
from heatlens.fronts.commands.command_parser import build_parser
from heatlens.fronts.commands.command_table import put_command_first
from heatlens.fronts.commands.main import main
from heatlens.fronts.commands.output import first_pictures
from support.command_line import ENVIRONMENT

NO_DISPLAY = {k: v for k, v in ENVIRONMENT.items() if k not in ("DISPLAY", "WAYLAND_DISPLAY")}


SMALL = """
from heatlens.fronts.commands import main
from heatlens.fronts.commands.output import first_pictures
first_pictures._SIZE = (80, 45)  # the size is not tested, and draws in a third of the time
raise SystemExit(main.main([]))
"""


def test_heatlens_without_display_writes_first_pictures(tmp_path):
    command = [sys.executable, "-c", SMALL]
    run = subprocess.run(command, env=NO_DISPLAY, cwd=tmp_path, capture_output=True, text=True)
    out, messages = run.stdout, run.stderr
    assert run.returncode == 0, messages
    assert messages.startswith("heatlens: No window can be opened") and "DISPLAY" in messages
    assert messages.count("\n") == 1
    with Image.open(tmp_path / "heatlens_still_life.png") as picture:
        assert picture.size == (640, 360) and np.asarray(picture).std() > 20
    with Image.open(tmp_path / "heatlens_pull.webp") as pull:
        assert pull.n_frames == 2 * first_pictures._FRAMES - 2 == 6
        first = np.asarray(pull.convert("RGB")).astype(float)
        pull.seek(first_pictures._FRAMES - 1)
        last = np.asarray(pull.convert("RGB")).astype(float)
    assert first.std() > 10 and np.abs(first - last).mean() > 2
    for name in ("heatlens_still_life.png", "heatlens_pull.webp"):
        assert str(tmp_path / name) in out


def test_first_pictures_suggest_valid_commands(capsys, monkeypatch, tmp_path, small_demo):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "argv", [str(tmp_path / "own env" / "bin" / "heatlens")])
    monkeypatch.setenv("PATH", "/nowhere")
    monkeypatch.setattr(first_pictures, "_render_frames", lambda _: [Image.new("RGB", (4, 4))] * 3)
    assert first_pictures.make_first_pictures(NoWindowError("No window: none. Help.")) == 0
    captured = capsys.readouterr()
    assert captured.err.startswith("heatlens: ") and "No window: none" in captured.err
    lines = [
        line for line in captured.out.splitlines() if line.startswith("  'own env/bin/heatlens' ")
    ]
    assert len(lines) >= 3
    for line in lines[:-1]:
        words = put_command_first(shlex.split(line)[1:])
        assert callable(build_parser().parse_args(words).run)


def test_program_name_is_shortest_command_that_starts_it(monkeypatch, tmp_path):
    """The bare name is returned only if it starts the same program."""
    program = tmp_path / ".venv" / "bin" / "heatlens"
    program.parent.mkdir(parents=True)
    shutil.copy(sys.executable, program)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "argv", [".venv/bin/heatlens"])
    monkeypatch.setenv("PATH", "/nowhere")
    assert first_pictures.start_command() == ".venv/bin/heatlens"
    monkeypatch.setattr(sys, "argv", [str(program)])
    assert first_pictures.start_command() == ".venv/bin/heatlens"
    monkeypatch.setenv("PATH", str(program.parent))
    assert first_pictures.start_command() == "heatlens"
    monkeypatch.setattr(sys, "argv", [str(tmp_path / "package" / "__main__.py")])
    assert first_pictures.start_command().endswith(" -m heatlens")


def test_heatlens_with_source_but_no_display_fails(capsys, monkeypatch):
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    assert main(["--demo"]) == 2
    assert "heatlens render" in capsys.readouterr().err

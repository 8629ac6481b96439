"""`heatlens` alone on a machine without a display ends in pictures, and says how to go on."""

import shlex
import shutil
import subprocess
import sys

import numpy as np
from PIL import Image

from heatlens.core.base.errors import NoWindowError
from heatlens.fronts.commands import first_pictures
from heatlens.fronts.commands.command_parser import build_parser
from heatlens.fronts.commands.command_table import with_command
from heatlens.fronts.commands.main import main
from support.command_line import ENVIRONMENT

NO_DISPLAY = {k: v for k, v in ENVIRONMENT.items() if k not in ("DISPLAY", "WAYLAND_DISPLAY")}


SMALL = """
from heatlens.fronts.commands import first_pictures, main
first_pictures._SIZE = (160, 90)  # a quarter of the pixels, which is half of the time
raise SystemExit(main.main([]))
"""


def test_without_a_display_there_are_pictures(tmp_path):
    command = [sys.executable, "-c", SMALL]
    run = subprocess.run(command, env=NO_DISPLAY, cwd=tmp_path, capture_output=True, text=True)
    out, said = run.stdout, run.stderr
    assert run.returncode == 0, said
    assert said.startswith("heatlens: No window can be opened") and "DISPLAY" in said
    assert said.count("\n") == 1
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


def test_the_commands_to_go_on_with_can_be_typed(capsys, monkeypatch, tmp_path, small_demo):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "argv", [str(tmp_path / "own env" / "bin" / "heatlens")])
    monkeypatch.setenv("PATH", "/nowhere")
    monkeypatch.setattr(first_pictures, "_shown_frames", lambda _: [Image.new("RGB", (4, 4))] * 3)
    assert first_pictures.make_first_pictures(NoWindowError("No window: none. Help.")) == 0
    said = capsys.readouterr()
    assert said.err.startswith("heatlens: ") and "No window: none" in said.err
    lines = [line for line in said.out.splitlines() if line.startswith("  'own env/bin/heatlens' ")]
    assert len(lines) >= 3
    for line in lines[:-1]:
        words = with_command(shlex.split(line)[1:])
        assert callable(build_parser().parse_args(words).run)


def test_the_program_is_named_as_it_was_started(monkeypatch, tmp_path):
    """By its name alone only where that starts the same program."""
    program = tmp_path / ".venv" / "bin" / "heatlens"
    program.parent.mkdir(parents=True)
    shutil.copy(sys.executable, program)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "argv", [".venv/bin/heatlens"])
    monkeypatch.setenv("PATH", "/nowhere")
    assert first_pictures.started_as() == ".venv/bin/heatlens"
    monkeypatch.setattr(sys, "argv", [str(program)])
    assert first_pictures.started_as() == ".venv/bin/heatlens"
    monkeypatch.setenv("PATH", str(program.parent))
    assert first_pictures.started_as() == "heatlens"
    monkeypatch.setattr(sys, "argv", [str(tmp_path / "package" / "__main__.py")])
    assert first_pictures.started_as().endswith(" -m heatlens")


def test_with_something_to_open_it_stays_an_error(capsys, monkeypatch):
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    assert main(["--demo"]) == 2
    assert "heatlens render" in capsys.readouterr().err

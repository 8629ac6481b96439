"""Test that the commands and examples of README and manual are valid and run."""

import argparse
import re
import shlex
import tomllib
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
import yaml

from heatlens import __version__
from heatlens.fronts.commands.command_parser import build_parser
from heatlens.fronts.commands.command_table import put_command_first
from heatlens.fronts.commands.main import main
from heatlens.studio.ui import window
from support.manual import manual_text, page

ROOT = Path(__file__).resolve().parents[2]


def shell_blocks() -> list[str]:
    """Return each block of shell commands, of the README and then of the manual."""
    text = (ROOT / "README.md").read_text() + manual_text()
    return [b.split("```")[0] for b in text.split("```sh\n")[1:]]


def code_lines() -> list[str]:
    return [line for block in shell_blocks() for line in block.splitlines()]


def test_ci_runs_test_command_of_readme() -> None:
    command = next(line for line in code_lines() if ".venv/bin/pytest" in line)
    assert command in (ROOT / ".ci" / "run").read_text().splitlines()


def test_pictures_of_readme_and_manual_exist() -> None:
    text = (ROOT / "README.md").read_text() + manual_text()
    for name in (
        "still_life.exr",
        "focus_fruit.png",
        "focus_lights.png",
        "window.png",
        "blender.png",
        "behind_guessed.png",
        "behind_known.png",
        "neighbours.webp",
        "demo.webp",
    ):
        assert f"assets/{name}" in text
        assert (ROOT / "assets" / name).stat().st_size > 10_000


def test_python_example_of_manual_runs(
    session_context: object, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)  # it writes a picture
    text = page("python").split("```python\n")[1].split("```")[0]
    code = text.replace("assets/", f"{ROOT.as_posix()}/assets/")
    depth_m = np.linspace(2.0, 6.0, 12, dtype=np.float32).reshape(3, 4)
    names: dict[str, object] = {"color": np.ones((3, 4, 3)), "depth_m": depth_m}
    exec(code, names)
    assert isinstance(names["picture"], np.ndarray) and names["picture"].shape == (360, 640, 4)
    assert len(names["pictures"]) == 3  # type: ignore[arg-type]
    assert names["files"] == (Path("still.png"),) and Path("still.png").is_file()


def parsers(parser: argparse.ArgumentParser) -> Iterator[argparse.ArgumentParser]:
    """Return the parser, those of its commands, and those of their actions."""
    yield parser
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            for inner in action.choices.values():
                yield from parsers(inner)


def examples() -> list[str]:
    """Return the command lines in README, manual and every help text."""
    text = (ROOT / "README.md").read_text() + manual_text()
    lines = [line for line in code_lines() if line.startswith("heatlens ")]
    lines += re.findall(r"`(?:\S*/)?(heatlens (?:\w+ )?[^\s`]*[-.][^\s`]*[^`\n]*)`", text)
    for parser in parsers(build_parser()):
        epilog = (parser.epilog or "").replace("\\\n", " ")
        lines += [line.strip() for line in epilog.splitlines() if line.startswith("  heatlens ")]
    return lines


def test_documents_have_examples_of_every_command():
    words = {line.split()[1] for line in examples()}
    assert words >= {"view", "render", "export", "shot", "camera", "info", "compare", "study"}
    assert len(examples()) > 45


def test_every_documented_command_line_parses():
    parser = build_parser()
    for line in examples():
        words = shlex.split(line.partition(" > ")[0], comments=True)[1:]
        try:
            assert callable(parser.parse_args(put_command_first(words)).run)
        except SystemExit as end:
            assert end.code == 0, line  # it printed help


def runnable_commands() -> list[str]:
    """Return the documented commands, without those that take minutes, wait, or have own tests.

    Scenes are drawn small and from few points of the lens, which is a third of the time.
    """
    skipped_words = "# minutes", "--listen", "heatlens doctor"
    lines = [line for line in code_lines() if line.startswith("heatlens ")]
    kept_lines = [line for line in lines if not any(words in line for words in skipped_words)]
    return [
        line.replace("--size 320x180", "--size 80x45").replace("--views 64", "--views 4")
        for line in kept_lines
    ]


def test_documented_commands_run_in_order(tmp_path, monkeypatch, capsys):
    """Run them in a folder with only the assets; opening a window is only recorded."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "assets").symlink_to(ROOT / "assets")
    opened_sources: list[str] = []
    monkeypatch.setattr(window, "run_window", lambda start: opened_sources.append(start.source))
    for line in runnable_commands():
        assert main(shlex.split(line, comments=True)[1:]) == 0, (line, capsys.readouterr().err)
    assert opened_sources == [
        "assets/still_life.exr",
        "pull.heatlens.json",
        "assets/still_life.exr",
    ]
    for name in ("two.png", "error.png", "pull.mp4", "cam.usda", "frames/pull.0103.exr"):
        assert (tmp_path / name).stat().st_size > 1000


def test_manual_lists_all_exit_codes():
    table = page("messages").partition("| exit code |")[2].partition("\n\n")[0]
    codes = [code for row in table.splitlines()[2:] for code in row.split("|")[1].split(",")]
    assert {int(code) for code in codes} == {0, 1, 2, 70, 130, 141, 143}


def test_citation_has_current_version_and_authors():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    assert citation["version"] == __version__
    assert citation["authors"] == project["authors"]
    assert citation["license"] == project["license"]


def test_readme_is_read_in_one_sitting():
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    words = re.sub(r"```.*?```", "", text, flags=re.DOTALL).split()
    assert len(text.splitlines()) <= 140 and len(words) <= 1500

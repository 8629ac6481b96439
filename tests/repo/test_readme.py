"""The README's commands are the ones that are run, and every example is one that can be typed."""

import argparse
import re
import shlex
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from heatlens.commands.main import _with_command, build_parser

ROOT = Path(__file__).resolve().parents[2]


def code_lines(text: str) -> list[str]:
    blocks = text.split("```sh\n")[1:]
    return [line for block in blocks for line in block.split("```")[0].splitlines()]


def test_ci_runs_the_readmes_test_command() -> None:
    command = next(
        line for line in code_lines((ROOT / "README.md").read_text()) if line.endswith("pytest")
    )
    assert command in (ROOT / ".ci" / "run").read_text().splitlines()


def test_what_the_readme_shows_is_there() -> None:
    text = (ROOT / "README.md").read_text()
    for name in (
        "still_life.exr",
        "focus_fruit.png",
        "focus_lights.png",
        "window.png",
        "demo.webp",
    ):
        assert f"assets/{name}" in text
        assert (ROOT / "assets" / name).stat().st_size > 10_000


def test_the_example_in_python_runs(session_context: object) -> None:
    text = (ROOT / "README.md").read_text().split("```python\n")[1].split("```")[0]
    code = text.replace("assets/", f"{ROOT.as_posix()}/assets/")
    depth_m = np.linspace(2.0, 6.0, 12, dtype=np.float32).reshape(3, 4)
    names: dict[str, object] = {"color": np.ones((3, 4, 3)), "depth_m": depth_m}
    exec(code, names)
    assert isinstance(names["picture"], np.ndarray) and names["picture"].shape == (360, 640, 4)
    assert len(names["pictures"]) == 3  # type: ignore[arg-type]


def parsers(parser: argparse.ArgumentParser) -> Iterator[argparse.ArgumentParser]:
    """It, its commands, and theirs."""
    yield parser
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            for inner in action.choices.values():
                yield from parsers(inner)


def examples() -> list[str]:
    """Command lines of the README, in its blocks and in its text, and of every help."""
    text = (ROOT / "README.md").read_text()
    lines = [line for line in code_lines(text) if line.startswith("heatlens ")]
    lines += re.findall(r"`(?:\S*/)?(heatlens (?:\w+ )?\S*[-.]\S*[^`\n]*)`", text)
    for parser in parsers(build_parser()):
        whole = (parser.epilog or "").replace("\\\n", " ")
        lines += [line.strip() for line in whole.splitlines() if line.startswith("  heatlens ")]
    return lines


def test_there_are_examples_of_every_command():
    words = {line.split()[1] for line in examples()}
    assert words >= {"view", "render", "export", "shot", "camera", "info", "compare", "study"}
    assert len(examples()) > 45


@pytest.mark.parametrize("line", examples())
def test_every_example_can_be_typed(line):
    words = shlex.split(line.partition(" > ")[0], comments=True)[1:]
    args = build_parser().parse_args(_with_command(words))
    assert callable(args.run)


def test_the_exit_codes_are_all_told():
    text = (ROOT / "README.md").read_text().partition("- Exit codes: ")[2]
    line = text.partition("\n\n")[0]
    assert {int(code) for code in re.findall(r"\b\d+\b", line)} == {0, 1, 2, 70, 130, 141, 143}

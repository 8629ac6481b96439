"""The README's commands are the ones that are run."""

from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]


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

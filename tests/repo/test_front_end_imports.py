"""Test that front ends import nothing from the session: they use the board alone.

A name that the board only imports and hands on counts as an import of its home.
"""

import ast
from collections.abc import Iterator
from pathlib import Path

import heatlens

PACKAGE = Path(heatlens.__file__).parent
TESTS = Path(__file__).resolve().parents[1]
SESSION, BOARD = "heatlens.studio.session", "heatlens.studio.board"
FRONT_ENDS = (
    PACKAGE / "studio/ui",
    PACKAGE / "studio/share",
    TESTS / "studio/ui",
    TESTS / "studio/share",
)


def imports(source: str) -> Iterator[tuple[str, str]]:
    """Yield each module and name that a source imports from a module."""
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.ImportFrom) and node.module:
            yield from ((node.module, alias.name) for alias in node.names)
        elif isinstance(node, ast.Import):
            yield from ((alias.name, "") for alias in node.names)


def homes(module: str, name: str) -> str:
    """Return the module where a name is defined, which may be further in than the one named."""
    path = PACKAGE.parent / f"{module.replace('.', '/')}.py"
    if not module.startswith(BOARD) or not path.is_file():
        return module
    found = [
        home for home, imported in imports(path.read_text(encoding="utf-8")) if imported == name
    ]
    return found[0] if found else module


def session_names(source: str) -> set[tuple[str, str]]:
    """Return module and name of all that a source imports from the session, or names in a text."""
    homed = {(homes(module, name), name) for module, name in imports(source)}
    homed |= {(text, "") for text in texts(source)}
    return {(home, name) for home, name in homed if f"{home}.".startswith(f"{SESSION}.")}


def texts(source: str) -> Iterator[str]:
    """Yield the texts in a source; a test may replace what a text names."""
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Constant) and isinstance(node.value, str):
            yield node.value


def test_front_ends_and_their_tests_import_nothing_from_the_session():
    files = [path for folder in FRONT_ENDS for path in folder.rglob("*.py")]
    assert len(files) > 100
    found = {path.name: session_names(path.read_text(encoding="utf-8")) for path in files}
    assert not {name: names for name, names in found.items() if names}


def test_a_name_that_the_board_hands_on_counts_as_an_import_of_its_home():
    home = f"{SESSION}.live.ring_follower"
    assert session_names(f"from {BOARD}.controls import RingFollower") == {(home, "RingFollower")}
    assert session_names(f"import {home}") == {(home, "")}
    assert session_names(f"patch('{home}._STEP', 1)") == {(f"{home}._STEP", "")}
    assert (
        session_names(f"from {BOARD}.board import Board\nfrom heatlens.core.base import x") == set()
    )

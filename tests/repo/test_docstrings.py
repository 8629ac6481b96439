"""Docstrings are sentences: a summary says what a function does, and is no fragment of a sentence.

ruff holds every summary to one line in the imperative mood (D205, D401), but it does not know words
such as "of" or "where" at the beginning. What begins with one of these is a fragment.

A name in backticks is that of something that exists.
"""

import ast
import re
import tomllib
from collections.abc import Iterator
from fnmatch import fnmatch
from functools import cache
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PACKAGE = ROOT / "app" / "heatlens"
NO_VERBS = frozenset(
    "a all also an and as at both by each either every false few first for from here how if in it "
    "its last many more most much neither next no none not nothing of on one only or others over "
    "same several so some such than that the their then there these they this those three till to "
    "true two under until what whatever when where whether which while who whose why with within "
    "without".split()
)


@cache
def unfinished_folders() -> list[str]:
    """Return the patterns of packages that pyproject.toml still excepts from the rule."""
    config = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    return list(config["tool"]["ruff"]["lint"].get("per-file-ignores", {}))


def is_finished(path: Path) -> bool:
    name = path.relative_to(ROOT).as_posix()
    return not any(fnmatch(name, pattern) for pattern in unfinished_folders())


def is_property(function: ast.FunctionDef) -> bool:
    return any("property" in ast.unparse(decorator) for decorator in function.decorator_list)


def begins_with_no_verb(docstring: str) -> bool:
    """Return True for a fragment, such as "Of the playhead." or "(H, W) metres."."""
    word = re.match(r"[A-Za-z]+", docstring)
    return word is None or word[0].lower() in NO_VERBS or word[0].endswith("Error")


def fragments_in(path: Path) -> Iterator[str]:
    """Return functions, not properties, whose docstring is a fragment, with their lines."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.FunctionDef) and not is_property(node):
            docstring = ast.get_docstring(node)
            if docstring and begins_with_no_verb(docstring):
                yield f"{path.relative_to(ROOT)}:{node.lineno}: {docstring.splitlines()[0]}"


def unknown_names_in_backticks() -> Iterator[str]:
    """Yield the names in backticks, in comments and docstrings, that occur nowhere else."""
    paths = [
        path
        for folder in ("app/heatlens", "tests", "shaders", "assets")
        for path in (ROOT / folder).rglob("*.*")
        if path.suffix in (".py", ".glsl")
    ]
    texts = {path: path.read_text(encoding="utf-8") for path in paths}
    words = {path.name.partition(".")[0] for path in paths}
    for text in texts.values():
        words.update(re.findall(r"\w+", re.sub(r"`\w+`", "", text)))
    for path, text in texts.items():
        for name in re.findall(r"`([A-Za-z]+_\w+)`", text):
            if name not in words:
                yield f"{path.relative_to(ROOT)}: {name}"


def test_names_in_backticks_exist():
    assert not list(unknown_names_in_backticks())


def test_no_docstring_summary_is_a_fragment():
    fragments = [
        line for path in PACKAGE.rglob("*.py") if is_finished(path) for line in fragments_in(path)
    ]
    assert not fragments, "\n".join(fragments)


@pytest.mark.parametrize(
    "docstring", ["Of the playhead.", "(H, W) metres.", "`frame` of it.", "InputError for nothing."]
)
def test_begins_with_no_verb_detects_fragments(docstring):
    assert begins_with_no_verb(docstring)


@pytest.mark.parametrize("docstring", ["Return the frame.", "Delete the mark."])
def test_begins_with_no_verb_accepts_sentences(docstring):
    assert not begins_with_no_verb(docstring)

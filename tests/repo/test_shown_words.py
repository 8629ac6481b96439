"""Test that texts for the user hold no class names of the program."""

import ast
import re
from collections.abc import Iterator
from pathlib import Path

PACKAGE = Path(__file__).resolve().parents[2] / "app" / "heatlens"
_HUMPS = re.compile(r"[A-Z][a-z0-9]+(?:[A-Z][a-z0-9]*)+")
_CLASS = re.compile(r"^ *class (\w+)", re.MULTILINE)


def sources() -> dict[str, str]:
    """Return the source text of each module by its path."""
    paths = PACKAGE.rglob("*.py")
    return {str(it.relative_to(PACKAGE)): it.read_text(encoding="utf-8") for it in paths}


def class_names() -> set[str]:
    """Return the names of classes that no sentence could hold by chance."""
    all_names = (name for text in sources().values() for name in _CLASS.findall(text))
    return {name for name in all_names if _HUMPS.fullmatch(name)}


def ids_of_hidden_texts(tree: ast.AST) -> set[int]:
    """Return the ids of string nodes that users never see: docstrings and type annotations."""
    nodes = [it.value for it in ast.walk(tree) if isinstance(it, ast.Expr)]
    for node in ast.walk(tree):
        types = (getattr(node, "annotation", None), getattr(node, "returns", None))
        nodes += [it for type_node in types if type_node is not None for it in ast.walk(type_node)]
    return {id(it) for it in nodes if isinstance(it, ast.Constant)}


def sentences(tree: ast.AST) -> Iterator[str]:
    """Yield the texts of more than one word."""
    hidden_ids = ids_of_hidden_texts(tree)
    for node in ast.walk(tree):
        if (
            isinstance(node, ast.Constant)
            and isinstance(node.value, str)
            and id(node) not in hidden_ids
        ):
            if " " in node.value.strip() or node.value.rstrip() != node.value:
                yield node.value


def texts_with_names(tree: ast.AST, names: set[str]) -> list[str]:
    return [text for text in sentences(tree) if names & set(_HUMPS.findall(text))]


def test_user_texts_hold_no_class_names():
    names = class_names()
    texts_of_files = {
        path: texts_with_names(ast.parse(source), names) for path, source in sources().items()
    }
    assert not {path: texts for path, texts in texts_of_files.items() if texts}


def test_class_name_in_sample_text_is_detected():
    tree = ast.parse(
        '"""A SharedSession."""\nwords = f"SharedSession: {1} is here"\nkey = "SharedSession"'
    )
    assert texts_with_names(tree, {"SharedSession"}) == ["SharedSession: "]
    assert "SharedSession" in class_names()

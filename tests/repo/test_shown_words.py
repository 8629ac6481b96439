"""What a user reads holds no names of the program's own."""

import ast
import re
from collections.abc import Iterator
from pathlib import Path

PACKAGE = Path(__file__).resolve().parents[2] / "app" / "heatlens"
_HUMPS = re.compile(r"[A-Z][a-z0-9]+(?:[A-Z][a-z0-9]*)+")
TREES = {path: ast.parse(path.read_text(encoding="utf-8")) for path in PACKAGE.rglob("*.py")}


def class_names() -> set[str]:
    """Return the names of classes that no sentence could hold by chance."""
    found = (it.name for tree in TREES.values() for it in ast.walk(tree) if _is_class(it))
    return {name for name in found if _HUMPS.fullmatch(name)}


def _is_class(node: ast.AST) -> bool:
    return isinstance(node, ast.ClassDef)


def unseen(tree: ast.AST) -> set[int]:
    """Return the texts that stand alone, which are docstrings, and those that are types."""
    found = [it.value for it in ast.walk(tree) if isinstance(it, ast.Expr)]
    for node in ast.walk(tree):
        types = (getattr(node, "annotation", None), getattr(node, "returns", None))
        found += [it for of in types if of is not None for it in ast.walk(of)]
    return {id(it) for it in found if isinstance(it, ast.Constant)}


def sentences(tree: ast.AST) -> Iterator[str]:
    """Yield the texts of more than one word."""
    own = unseen(tree)
    for node in ast.walk(tree):
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and id(node) not in own:
            if " " in node.value.strip() or node.value.rstrip() != node.value:
                yield node.value


def named(tree: ast.AST, names: set[str]) -> list[str]:
    return [text for text in sentences(tree) if names & set(_HUMPS.findall(text))]


def test_no_sentence_holds_the_name_of_a_class():
    names = class_names()
    found = {str(path.relative_to(PACKAGE)): named(tree, names) for path, tree in TREES.items()}
    assert not {path: texts for path, texts in found.items() if texts}


def test_the_law_finds_one():
    tree = ast.parse(
        '"""A SharedSession."""\nwords = f"SharedSession: {1} is here"\nkey = "SharedSession"'
    )
    assert named(tree, {"SharedSession"}) == ["SharedSession: "]
    assert "SharedSession" in class_names()

"""Only gpu/ knows the library that draws; everything else speaks of a device and what it makes."""

import ast
import importlib
import pkgutil
import re
from pathlib import Path

import heatlens

PACKAGE = Path(heatlens.__file__).parent
TESTS = Path(__file__).parents[1]
LIBRARY = "moderngl"
# Names of the library's objects, and constants of OpenGL, outside of words and comments.
_INSIDE = re.compile(r"\.m?glo\b|\bGL_[A-Z]")
# Tests of gpu alone may know the library; the fixtures of contexts are one.
TESTS_OF_GPU = {"support/contexts.py"}
# Modules that run when they are imported.
NOT_LOADED = {"heatlens.__main__"}


def names_inside(path: Path) -> bool:
    """Return whether a file names what lies within, outside of its comments and docstrings."""
    text = path.read_text(encoding="utf-8")
    if not _INSIDE.search(text):  # nearly all files, which need not be parsed
        return False
    return bool(_INSIDE.search(ast.unparse(_without_docstrings(ast.parse(text)))))


def _without_docstrings(tree: ast.AST) -> ast.AST:
    for node in ast.walk(tree):
        body = getattr(node, "body", None)
        if isinstance(body, list) and body and isinstance(body[0], ast.Expr):
            body[0] = ast.Pass()
    return tree


def imports_library(path: Path) -> bool:
    text = path.read_text(encoding="utf-8")
    for node in ast.walk(ast.parse(text)) if LIBRARY in text else ():
        names = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
        names += [node.module or ""] if isinstance(node, ast.ImportFrom) else []
        if any(name.partition(".")[0] == LIBRARY for name in names):
            return True
    return False


def outside() -> list[Path]:
    found = [
        p
        for p in sorted(PACKAGE.rglob("*.py"))
        if p.relative_to(PACKAGE).parts[:2] != ("render", "gpu")
    ]
    assert len(found) > 300
    return found


def test_nothing_outside_imports_the_library():
    assert [str(path) for path in outside() if imports_library(path)] == []
    assert any(imports_library(path) for path in (PACKAGE / "render/gpu").rglob("*.py"))


def test_nothing_outside_names_what_lies_within():
    assert [str(path) for path in outside() if names_inside(path)] == []
    assert _INSIDE.search("texture.glo") and _INSIDE.search('info["GL_RENDERER"]')


def test_only_tests_of_gpu_import_the_library():
    found = {p.relative_to(TESTS).as_posix() for p in TESTS.rglob("*.py") if imports_library(p)}
    assert found == TESTS_OF_GPU


def test_no_module_outside_holds_a_thing_of_the_library():
    held = []
    for found in pkgutil.walk_packages(heatlens.__path__, "heatlens."):
        if found.name in NOT_LOADED or found.name.startswith("heatlens.render.gpu"):
            continue
        module = importlib.import_module(found.name)
        held += [f"{found.name}.{name}" for name, it in vars(module).items() if _is_of(it)]
    assert held == []


def _is_of(thing: object) -> bool:
    owner = getattr(thing, "__module__", None)
    return isinstance(owner, str) and owner.partition(".")[0] == LIBRARY

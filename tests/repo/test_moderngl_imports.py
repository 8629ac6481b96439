"""Test that only render/gpu/ knows moderngl and wgpu; all else uses the device and its objects."""

import ast
import importlib
import pkgutil
import re
from pathlib import Path

import heatlens

PACKAGE = Path(heatlens.__file__).parent
TESTS = Path(__file__).parents[1]
LIBRARIES = {"moderngl", "wgpu"}
# Names of the library's objects, and constants of OpenGL, outside of words and comments.
_INSIDE = re.compile(r"\.m?glo\b|\bGL_[A-Z]")
# Tests of gpu alone may know the library; the fixtures of contexts are one.
TESTS_OF_GPU = {"support/contexts.py"}
# Modules that run when they are imported.
# The program itself, and what only Windows can import.
NOT_LOADED = {"heatlens.__main__", "heatlens.core.base.windows_calls"}


def uses_library_internals(path: Path) -> bool:
    """Return whether the code of a file, without docstrings, names moderngl or GL internals."""
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
    for node in ast.walk(ast.parse(text)) if any(name in text for name in LIBRARIES) else ():
        names = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
        names += [node.module or ""] if isinstance(node, ast.ImportFrom) else []
        if any(name.partition(".")[0] in LIBRARIES for name in names):
            return True
    return False


def files_outside_gpu() -> list[Path]:
    files = [
        p
        for p in sorted(PACKAGE.rglob("*.py"))
        if p.relative_to(PACKAGE).parts[:2] != ("render", "gpu")
    ]
    assert len(files) > 300
    return files


def test_only_gpu_folder_imports_moderngl():
    assert [str(path) for path in files_outside_gpu() if imports_library(path)] == []
    assert any(imports_library(path) for path in (PACKAGE / "render/gpu").rglob("*.py"))


def test_only_gpu_folder_uses_moderngl_internals():
    assert [str(path) for path in files_outside_gpu() if uses_library_internals(path)] == []
    assert _INSIDE.search("texture.glo") and _INSIDE.search('info["GL_RENDERER"]')


def test_only_context_fixtures_of_tests_import_moderngl():
    importing_tests = {
        p.relative_to(TESTS).as_posix() for p in TESTS.rglob("*.py") if imports_library(p)
    }
    assert importing_tests == TESTS_OF_GPU


def test_modules_outside_gpu_hold_no_moderngl_objects():
    library_objects = []
    for module_info in pkgutil.walk_packages(heatlens.__path__, "heatlens."):
        if module_info.name in NOT_LOADED or module_info.name.startswith("heatlens.render.gpu"):
            continue
        module = importlib.import_module(module_info.name)
        library_objects += [
            f"{module_info.name}.{name}"
            for name, it in vars(module).items()
            if _is_library_object(it)
        ]
    assert library_objects == []


def _is_library_object(thing: object) -> bool:
    owner = getattr(thing, "__module__", None)
    return isinstance(owner, str) and owner.partition(".")[0] in LIBRARIES

"""Test that nothing sets a function on another object after its construction.

An object that waits for others to complete it looks ready before it is. What it calls is given to
its constructor, or to the call that needs it.
"""

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

import heatlens

PACKAGE = Path(heatlens.__file__).parent
Function = ast.FunctionDef | ast.AsyncFunctionDef


def has_callable_type(annotation: ast.expr | None) -> bool:
    """Return whether an annotation says that its value can be called."""
    return annotation is not None and "Callable" in ast.unparse(annotation)


def method_names(tree: ast.Module) -> set[str]:
    """Return the names of the methods in a file; a property is a value."""
    return {
        node.name
        for kind in ast.walk(tree)
        if isinstance(kind, ast.ClassDef)
        for node in kind.body
        if isinstance(node, Function)
        and not any("property" in ast.unparse(decorator) for decorator in node.decorator_list)
    }


def callable_names(tree: ast.Module) -> set[str]:
    """Return the names in a file of functions, own or imported, and of values of type Callable."""
    names = set()
    kinds = [node for node in ast.walk(tree) if isinstance(node, ast.ClassDef)]
    of_classes = {id(node) for kind in kinds for node in kind.body}
    for node in ast.walk(tree):
        if isinstance(node, Function) and id(node) not in of_classes:
            names.add(node.name)
        elif isinstance(node, ast.ImportFrom) and (node.module or "").startswith("heatlens."):
            names |= {alias.name for alias in node.names if alias.name.islower()}
        elif isinstance(node, ast.arg) and has_callable_type(node.annotation):
            names.add(node.arg)
        elif isinstance(node, ast.AnnAssign) and has_callable_type(node.annotation):
            names.add(ast.unparse(node.target).rpartition(".")[2])
    return names


def is_function(value: ast.expr, names: set[str], methods: set[str]) -> bool:
    """Return whether a value is a function, a method or a lambda, by the names in its file."""
    if isinstance(value, ast.IfExp):
        return is_function(value.body, names, methods) or is_function(value.orelse, names, methods)
    if isinstance(value, ast.Call):
        return ast.unparse(value.func) in ("partial", "functools.partial")
    if isinstance(value, ast.Name):
        return value.id in names
    if isinstance(value, ast.Attribute):
        return value.attr in names | methods
    return isinstance(value, ast.Lambda)


def own_names(tree: ast.Module) -> set[str]:
    """Return the names whose attributes are not those of another object of heatlens.

    These are `self` and `cls`, and modules and classes of libraries, which offer no constructor.
    """
    names = {"self", "cls"}
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            names |= {alias.asname or alias.name.partition(".")[0] for alias in node.names}
        elif isinstance(node, ast.arg) and node.annotation is not None:
            names |= {node.arg} if ast.unparse(node.annotation) in ("ModuleType", "Any") else set()
    return names


def is_of_another_object(target: ast.expr, own: set[str]) -> bool:
    """Return whether a target is an attribute of another object: `a.b.c`, or `a.b` of another."""
    if not isinstance(target, ast.Attribute):
        return False
    if not isinstance(target.value, ast.Name):
        root = ast.unparse(target.value).partition(".")[0]
        return root not in own - {"self", "cls"}
    return target.value.id not in own


def outside_assignments(tree: ast.Module) -> list[ast.Assign]:
    """Return the assignments to attributes of other objects."""
    assignments = [node for node in ast.walk(tree) if isinstance(node, ast.Assign)]
    if not any(
        isinstance(target, ast.Attribute) for node in assignments for target in node.targets
    ):
        return []
    own = own_names(tree)
    return [
        node
        for node in assignments
        if any(is_of_another_object(target, own) for target in node.targets)
    ]


def hooks(text: str) -> Iterator[str]:
    """Yield the assignments in a file that set a function on another object."""
    tree = ast.parse(text)
    assignments = outside_assignments(tree)
    if not assignments:
        return
    names, methods = callable_names(tree), method_names(tree)
    for node in assignments:
        if is_function(node.value, names, methods):
            yield f"{node.lineno}: {ast.unparse(node)}"


@pytest.mark.parametrize(
    "line",
    [
        "def f(wake: Callable[[], None]): shared.wake = wake",
        "class A:\n def f(self): self.shared.wake = self.f",
        "def f(control): control.pictures.make_still = lambda: None",
        "from heatlens.studio.ui.devices import pad_axes\nstart.lens_in.read = pad_axes",
        "def f(shown): shown.alt.is_taken = partial(f, 1)",
        "class A:\n def f(self): self.pipelines[0].on_layer = self.f",
    ],
)
def test_hook_search_finds_each_kind_of_hook(line):
    assert list(hooks(line))


@pytest.mark.parametrize(
    "line",
    [
        "def f(self, wake: Callable[[], None]): self._wake = wake",
        "def f(self): self.editing.frame = 3",
        "class A:\n @property\n def look(self): still.look = self.look",
        "def f(library: ModuleType): library.pickle.loads = f",
    ],
)
def test_hook_search_ignores_own_attributes_values_and_libraries(line):
    assert not list(hooks(line))


def test_no_function_is_set_on_another_object():
    files = sorted(PACKAGE.rglob("*.py"))
    found = {
        str(path.relative_to(PACKAGE)): list(hooks(path.read_text(encoding="utf-8")))
        for path in files
    }
    assert len(files) > 500
    assert not {name: lines for name, lines in found.items() if lines}

"""Test the layers of the package: a file imports only from its own and lower layers, and is small.

Read from the syntax tree, so that an import inside a function counts as well.
"""

import ast
import importlib
import re
import sys
from collections import Counter
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from functools import cache
from pathlib import Path

import pytest

import heatlens

PACKAGE = Path(heatlens.__file__).parent
# Each wing, a folder of the package, with its rooms, the folders in it. Both are in order: what is
# further down may import what stands above it. A hall is a room that has many folders itself.
WINGS = {
    "core": ("base", "model"),
    "media": (
        *("files", "sequence", "plate", "frame_cache", "live", "documents"),
        *("scene", "camera", "color"),
    ),
    "render": (
        *("gpu", "defocus", "scene_gpu", "source", "plate_blur", "frame_renderer"),
        *("preview", "rendered_frames", "display"),
    ),
    "deliver": ("export", "farm"),
    "studio": ("settings", "session", "board", "share", "ui"),
    "fronts": ("doctor", "api", "commands"),
    "lab": ("measure", "commands"),
}
LAYERS = tuple(f"{wing}.{room}" for wing, rooms in WINGS.items() for room in rooms)
FOLDERS_MAX, WING_SHARE_MAX, PAIRS_MAX = 8, 0.45, 22
_OF_WINDOWS = (
    *("heatlens.studio.ui", "imgui_bundle", "glfw", "support.gui"),
    *("support.scene_window", "support.timeline_window", "support.window_plates"),
)
LINES_WARNED, LINES_MAX = 300, 500
FUNCTION_LINES_MAX = 42
LONG_FILES = 16  # with more than LINES_WARNED
FILES_OF_A_HALL, FILES_OF_OTHERS, FILES_AT_THE_ROOT = 24, 40, 5
FILES = sorted(PACKAGE.rglob("*.py"))


def layer_of(module: str) -> str:
    """Return the layer of a module below heatlens: "media.plate.depth" is in "media.plate".

    A wing by itself is the layer of its first room: its `__init__` imports nothing.
    """
    wing, *parts = module.split(".")
    if wing == "__main__":
        return "fronts.commands"  # python -m heatlens is the command line
    if wing in ("", "__init__", "version"):
        return LAYERS[0]
    return f"{wing}.{parts[0]}" if parts and parts[0] != "__init__" else wing


def imported_modules(source: str) -> Iterator[str]:
    """Return the dotted modules that `source` imports; relative ones as written."""
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            base = "." * node.level + (node.module or "")
            # `from heatlens import gpu` names a layer too; `from heatlens import __version__` none.
            yield from (f"{base}.{a.name}" if base == "heatlens" else base for a in node.names)


def layers_of(modules: Iterable[str]) -> set[str]:
    """Return the layers of those modules that are of heatlens."""
    inner = {name.partition(".")[2] for name in modules if name.startswith("heatlens")}
    return {LAYERS[0] if name.startswith("__version__") else layer_of(name) for name in inner}


def module_of(path: Path) -> str:
    return ".".join(path.relative_to(PACKAGE).with_suffix("").parts)


def own_layer(path: Path) -> str:
    return layer_of(module_of(path))


def calls_print(source: str) -> bool:
    return "print(" in source and any(
        isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == "print"
        for node in ast.walk(ast.parse(source))
    )


@cache
def source_of(path: Path) -> str:
    return path.read_text(encoding="utf-8")


@cache
def modules_imported(path: Path) -> frozenset[str]:
    return frozenset(imported_modules(source_of(path)))


def packages_imported(path: Path) -> set[str]:
    return {name.partition(".")[0] for name in modules_imported(path)}


def offenders(is_wrong: Callable[[Path], object]) -> list[str]:
    """Return the modules that break a rule."""
    assert len(FILES) > 100
    return [module_of(path) for path in FILES if is_wrong(path)]


def test_every_file_is_in_known_layer():
    assert not offenders(lambda path: layer_of(module_of(path)) not in (*LAYERS, *WINGS))
    assert set(LAYERS) <= {layer_of(module_of(path)) for path in FILES}


def wing_of(path: Path) -> str:
    """Return the wing of a file; the package itself is a front, whose names it hands on."""
    first = path.relative_to(PACKAGE).parts[0]
    return first if first in WINGS else "core" if first == "version.py" else "fronts"


def wings_imported(path: Path) -> set[str]:
    """Return the other wings that a file imports from, also in functions and for types."""
    inner = {name.partition(".")[2] for name in modules_imported(path) if name[:9] == "heatlens."}
    return {name.partition(".")[0] for name in inner if name.partition(".")[0] in WINGS} - {
        wing_of(path)
    }


def test_wings_import_only_from_earlier_wings():
    order = list(WINGS)
    pairs = {(wing_of(path), wing) for path in FILES for wing in wings_imported(path)}
    assert len(pairs) <= PAIRS_MAX
    assert [
        (importer, imported)
        for importer, imported in pairs
        if order.index(importer) < order.index(imported)
    ] == []
    assert not {importer for importer, imported in pairs if imported == "lab"}


def test_package_has_only_the_listed_top_folders():
    folders = {path.name for path in PACKAGE.iterdir() if path.is_dir()} - {"__pycache__"}
    assert folders == set(WINGS) and len(folders) <= FOLDERS_MAX


def test_no_wing_has_more_than_45_percent_of_lines():
    lines = Counter[str]()
    for path in FILES:
        lines[wing_of(path)] += len(source_of(path).splitlines())
    assert max(lines.values()) <= WING_SHARE_MAX * lines.total(), lines


@pytest.mark.parametrize("wing", WINGS)
def test_wing_init_has_only_a_docstring(wing):
    tree = ast.parse(source_of(PACKAGE / wing / "__init__.py"))
    assert len(tree.body) == 1, "a docstring alone"
    words = ast.get_docstring(tree) or ""
    assert words.startswith(f"{wing.capitalize()}: ") and 4 <= len(words.splitlines()) <= 6


# Named by a text and imported on first use, because they lie further up than who names them.
NAMED_ON_USE = {
    "core.model.marks.marks": {"media.plate.mark_distance"},
    "fronts.api.exporting": {"fronts.commands.export_for_python"},
    "render.source.kinds": {
        *("fronts.api.opening", "fronts.commands.sources.of_plates"),
        *("fronts.commands.sources.of_scenes", "fronts.commands.sources.source_commands"),
        "studio.session.opened.picture_feed",
    },
}


def names_on_use(path: Path) -> list[tuple[str, str]]:
    """Return each module and name that a file gives to `OnUse`."""
    text = source_of(path)
    return [
        (node.args[0].value, node.args[1].value)
        for node in (ast.walk(ast.parse(text)) if "OnUse(" in text else ())
        if isinstance(node, ast.Call)
        and isinstance(node.func, ast.Name)
        and node.func.id == "OnUse"
    ]


def test_names_imported_on_use_exist():
    for path in FILES:
        for module, name in names_on_use(path):
            assert hasattr(importlib.import_module(f"heatlens.{module}"), name), (path, module)


def test_on_use_imports_from_higher_layers_are_listed():
    names_further_up: dict[str, set[str]] = {}
    for path in FILES:
        own_index = LAYERS.index(importing_layer(path)) if names_on_use(path) else 0
        higher_names = {
            name for name, _ in names_on_use(path) if LAYERS.index(layer_of(name)) > own_index
        }
        if higher_names:
            names_further_up[module_of(path)] = higher_names
    assert names_further_up == NAMED_ON_USE


_DEFINITION = re.compile(r"^(?:def \w+\(|class \w+[(:])", re.MULTILINE)  # which is no import


def test_no_module_consists_of_imports_only():
    def hands_on(path: Path) -> bool:
        if _DEFINITION.search(source_of(path)):
            return False
        body = ast.parse(source_of(path)).body
        other_statements = [
            node
            for node in body
            if not isinstance(node, ast.Import | ast.ImportFrom)
            and not (isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant))
        ]
        return len(body) > 1 and not other_statements

    assert not offenders(hands_on)


def importing_layer(path: Path) -> str:
    """Return the layer of a file; the package itself counts as `api`, which it re-exports."""
    own_layer_name = layer_of(module_of(path))
    first_layers = {wing: f"{wing}.{rooms[0]}" for wing, rooms in WINGS.items()}
    return (
        "fronts.api"
        if module_of(path) == "__init__"
        else first_layers.get(own_layer_name, own_layer_name)
    )


def test_files_import_only_from_own_and_lower_layers():
    def reaches_up(path: Path) -> bool:
        own_index = LAYERS.index(importing_layer(path))
        reached = layers_of(modules_imported(path)) - WINGS.keys()
        return any(LAYERS.index(name) > own_index for name in reached)

    assert not offenders(reaches_up)


def test_all_imports_are_absolute():
    assert not offenders(lambda path: any(m.startswith(".") for m in modules_imported(path)))


@pytest.mark.parametrize(
    "libraries, layers",
    [({"moderngl"}, ("render.gpu",)), ({"imgui_bundle", "glfw"}, ("studio.ui",))],
    ids=["OpenGL", "window"],
)
def test_opengl_and_window_libraries_stay_in_their_layers(libraries, layers):
    def is_foreign(path: Path) -> bool:
        return bool(packages_imported(path) & libraries) and own_layer(path) not in layers

    assert not offenders(is_foreign)
    assert any(packages_imported(path) & libraries for path in FILES)


def test_base_and_model_import_only_numpy_and_platformdirs():
    known = sys.stdlib_module_names | {"numpy", "heatlens", "platformdirs"}  # this one for base
    low = ("core.base", "core.model")
    assert not offenders(lambda path: own_layer(path) in low and packages_imported(path) - known)


def test_only_ui_layer_uses_window_state_and_panels():
    """Layers below the window may not use it, not even for a type."""
    window_names = {"UiState", "App"}

    def asks_for_it(path: Path) -> bool:
        users = any(name.startswith("heatlens.studio.ui") for name in modules_imported(path))
        return own_layer(path) != "studio.ui" and (
            (users and own_layer(path) not in ("fronts.doctor", "fronts.commands"))
            or bool(window_names & _names_in(source_of(path), window_names))
        )

    assert not offenders(asks_for_it)


def _names_in(source: str, wanted: set[str]) -> set[str]:
    """Return every name in a source that holds one of `wanted`, also in a quoted annotation."""
    if not any(name in source for name in wanted):
        return set()
    tree = ast.parse(source)
    names = {node.id for node in ast.walk(tree) if isinstance(node, ast.Name)}
    return names | {
        node.value
        for node in ast.walk(tree)
        if isinstance(node, ast.Constant) and isinstance(node.value, str)
    }


@cache
def _names_imported(path: Path) -> frozenset[str]:
    """Return the modules that a file imports or imports names of, and each as `module.name`."""
    imported: set[str] = set()
    for node in ast.walk(ast.parse(source_of(path))):
        if isinstance(node, ast.Import):
            imported |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            imported |= {node.module, *(f"{node.module}.{alias.name}" for alias in node.names)}
    return frozenset(imported)


def modules_imported_by(path: Path, modules: Collection[str]) -> set[str]:
    """Return the modules that a file imports, also under TYPE_CHECKING and in functions."""
    imported = _names_imported(path)
    inner = {name.partition(".")[2] for name in imported if name.startswith("heatlens.")}
    return {name for name in inner if name in modules}


def import_cycles(arrows: Mapping[str, Collection[str]]) -> list[list[str]]:
    """Return the import cycles: the nodes left after all without arrows in or out are removed."""
    remaining = {name: set(targets) for name, targets in arrows.items()}
    while True:
        ends = {name for name, targets in remaining.items() if not targets & remaining.keys()}
        ends |= {
            name for name in remaining if not any(name in targets for targets in remaining.values())
        }
        if not ends:
            return [sorted(remaining)] if remaining else []
        remaining = {
            name: targets - ends for name, targets in remaining.items() if name not in ends
        }


def test_files_have_no_import_cycle():
    """Imports for types count as well, as files that name each other belong together."""
    modules = {module_of(path).removesuffix(".__init__"): path for path in FILES}
    modules.pop("__init__", None)  # it hands on what the layers have, when asked
    arrows = {name: modules_imported_by(path, modules) - {name} for name, path in modules.items()}
    assert import_cycles(arrows) == []


HALLS = ("core.model", "studio.ui", "studio.session", "media.plate", "fronts.commands")


@pytest.mark.parametrize("hall", HALLS)
def test_subfolders_of_large_layers_have_no_import_cycle(hall):
    """The subfolders of a large layer have an order as layers do; files beside them join them."""
    modules = {module_of(path).removesuffix(".__init__"): path for path in FILES}
    arrows: dict[str, set[str]] = {}
    for name, path in modules.items():
        room = room_of(hall, name)
        if room is not None:
            targets = {room_of(hall, target) for target in modules_imported_by(path, modules)}
            arrows.setdefault(room, set()).update(t for t in targets if t not in (None, room))
    assert len(arrows) > 3
    assert import_cycles(arrows) == []


def room_of(hall: str, module: str) -> str | None:
    """Return the subfolder of the layer `hall` that a module lies in, None for other modules."""
    parts = module.split(".")
    return parts[2] if layer_of(module) == hall and len(parts) > 3 else None


def test_folders_stay_below_file_limit():
    """Short folders make a feature easy to find."""
    for folder, count in Counter(path.parent for path in FILES).items():
        has_rooms = ".".join(folder.relative_to(PACKAGE).parts) in {*HALLS} - {"studio.ui"}
        file_limit = FILES_OF_A_HALL if has_rooms else FILES_OF_OTHERS
        file_limit = FILES_AT_THE_ROOT if folder == PACKAGE else file_limit
        assert count <= file_limit, folder


@pytest.mark.parametrize("room", ["session", "board"])
def test_tests_of_sessions_import_no_window_modules(room):
    tests = sorted(Path(__file__).parents[1].glob(f"studio/{room}/*.py"))
    assert tests
    for test in tests:
        users = set(imported_modules(test.read_text(encoding="utf-8")))
        assert not {name for name in users if name.startswith(_OF_WINDOWS)}, test.name


def test_only_command_modules_call_print():
    assert not offenders(
        lambda path: not own_layer(path).endswith(".commands") and calls_print(source_of(path))
    )


def test_no_file_has_more_than_500_lines():
    """A file of more than 300 lines may hold two ideas; 500 lines are the limit.

    `python tests/repo/test_layers.py` lists the files of more than 300 lines.
    """
    assert not {name: count for name, count in lines_of_files().items() if count > LINES_MAX}


def lines_of_files() -> dict[str, int]:
    """Return the lines of each file, the longest first."""
    lines = {module_of(path): len(source_of(path).splitlines()) for path in FILES}
    return dict(sorted(lines.items(), key=lambda it: -it[1]))


def test_no_function_has_more_than_42_lines():
    """A function that is longer than a screen usually does several things."""
    long = {
        f"{module_of(path)}:{node.lineno} {node.name}": node.end_lineno - node.lineno + 1
        for path in FILES
        for node in ast.walk(ast.parse(source_of(path)))
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef)
    }
    assert not {name: count for name, count in long.items() if count > FUNCTION_LINES_MAX}


def test_files_of_more_than_300_lines_do_not_become_more():
    """To let one file grow beyond 300 lines, another has to be shortened."""
    assert sum(count > LINES_WARNED for count in lines_of_files().values()) <= LONG_FILES


def test_layer_checks_detect_sample_violations():
    source = (
        "def f():\n    from heatlens import render\n    import heatlens.media.plate.a\n    print(1)"
    )
    assert layers_of(imported_modules(source)) == {"render", "media.plate"}
    assert calls_print(source)
    assert list(imported_modules("from . import plate")) == ["."]
    assert layers_of(imported_modules("from heatlens import __version__")) == {"core.base"}
    assert layers_of(["heatlens.core.base.errors"]) == {"core.base"}
    assert import_cycles({"a": {"b"}, "b": {"c"}, "c": {"b"}, "d": {"a"}}) == [["b", "c"]]
    assert import_cycles({"a": {"b", "c"}, "b": {"c"}, "c": set()}) == []


if __name__ == "__main__":
    for long, count in lines_of_files().items():
        if count > LINES_WARNED:
            print(f"{count:4} {long}")

"""Test that few modules ask for the kind of a source; each is listed here with its reason.

Everything else asks a source what it can do: see `heatlens.render.source.source.Source`.
"""

import ast
import re
from functools import cache
from pathlib import Path

import heatlens

PACKAGE = Path(heatlens.__file__).parent
# Modules that may look up the record of a kind.
MAY_ASK_THE_KIND = {
    "fronts.api.opening": "opens a source by the record of its kind",
    "lab.commands.bench_scene": "a truth is for sources with many views alone",
    "fronts.commands.options.given_options": "refuses options of kinds that the record names",
    "fronts.commands.sources.source_commands": "reads a source on the command line by its record",
    "studio.session.live.sent_lens": "a renderer may send its lens after its picture",
    "studio.settings.cards": "the start screen names the kind of a recent file",
}
# Modules that may ask whether there is a 3D scene: they draw or do what only scenes have.
MAY_ASK_FOR_A_SCENE = {
    "fronts.commands.output.picture_progress": "counts the steps of a scene",
    "studio.session.pictures.look_pictures": "looks of a scene have a renderer of their own",
    "studio.session.scenes.following": "another scene ends the following",
    "studio.session.playing.ahead_jobs": "the place of the camera is part of a frame's key",
    "studio.session.playing.frames_ahead": "the scene is shared with the renderer of frames ahead",
}
KINDS = {
    *("PlateSource", "SceneSource", "StreamSource"),
    *("OpenedPlates", "OpenedScene", "OpenedStream"),
}
# Flags of the kind that once stood in many places.
REMOVED_FLAGS = {"is_streaming", "is_scene", "is_plate", "of_scene", "names_scene", "has_scene"}


def module_of(path: Path) -> str:
    return ".".join(path.relative_to(PACKAGE).with_suffix("").parts)


@cache
def sources() -> dict[str, str]:
    """Return the texts of all modules outside source/."""
    paths = {module_of(path): path for path in sorted(PACKAGE.rglob("*.py"))}
    return {
        name: path.read_text(encoding="utf-8")
        for name, path in paths.items()
        if not name.startswith("render.source.")
    }


def trees_with(pattern: str) -> dict[str, ast.AST]:
    """Return the syntax trees of the modules whose text holds a match; few need to be parsed."""
    return {name: ast.parse(text) for name, text in sources().items() if re.search(pattern, text)}


def asks_the_kind(tree: ast.AST) -> bool:
    """Return True for isinstance with a kind, a use of SourceKind, and `kind_of` of a source."""
    imported = {
        alias.asname or alias.name
        for node in ast.walk(tree)
        if isinstance(node, ast.ImportFrom) and node.module == "heatlens.render.source.kinds"
        for alias in node.names
    } - {"NO_FILES", "STREAM_PREFIX"}
    return any(
        (isinstance(node, ast.Name) and node.id in imported)
        or (
            isinstance(node, ast.Call)
            and isinstance(node.func, ast.Name)
            and node.func.id == "isinstance"
            and bool(KINDS & names_in(node.args[1]))
        )
        for node in ast.walk(tree)
    )


def asks_for_a_scene(tree: ast.AST) -> bool:
    """Return True for `x.scene is None` or its opposite."""
    return any(isinstance(node, ast.Compare) and compares_a_scene(node) for node in ast.walk(tree))


def compares_a_scene(node: ast.Compare) -> bool:
    is_scene = isinstance(node.left, ast.Attribute) and node.left.attr == "scene"
    return is_scene and any(isinstance(op, ast.Is | ast.IsNot) for op in node.ops)


def names_in(node: ast.AST) -> set[str]:
    return {child.id for child in ast.walk(node) if isinstance(child, ast.Name)} | {
        child.attr for child in ast.walk(node) if isinstance(child, ast.Attribute)
    }


def test_only_listed_modules_ask_for_source_kind():
    trees = trees_with("|".join((*KINDS, r"render\.source\.kinds")))
    assert {name for name, tree in trees.items() if asks_the_kind(tree)} == set(MAY_ASK_THE_KIND)


def test_only_listed_modules_check_for_scene():
    trees = trees_with(r"\.scene\)*\s+is\b")
    asking_modules = {name for name, tree in trees.items() if asks_for_a_scene(tree)}
    assert asking_modules == set(MAY_ASK_FOR_A_SCENE)


def test_removed_kind_flags_are_not_used():
    trees = trees_with("|".join(REMOVED_FLAGS))
    flags_of_modules = {name: REMOVED_FLAGS & names_in(tree) for name, tree in trees.items()}
    # Here a name is looked at; heatlens.render.source.kinds asks for all others.
    del flags_of_modules["media.scene.scene_read"]
    assert {name: flags for name, flags in flags_of_modules.items() if flags} == {}


def test_source_kind_checks_detect_samples():
    asks = ("isinstance(x, OpenedScene)", "isinstance(x, (int, opened.OpenedPlates))")
    assert all(asks_the_kind(ast.parse(text)) for text in asks)
    by_name = "from heatlens.render.source.kinds import kind_of\nkind_of(text)"
    assert asks_the_kind(ast.parse(by_name))
    assert not asks_the_kind(ast.parse("isinstance(x, Plate)\nkind_of(text)"))
    for text in ("self.renderer.scene is None", "a.scene is not b.scene"):
        assert asks_for_a_scene(ast.parse(text))
    assert not asks_for_a_scene(ast.parse("scene is None\nself.scene.frames"))
    assert REMOVED_FLAGS & names_in(ast.parse("app.source.is_streaming"))

"""Test what front ends import of the session: the board is their door, and the list shrinks.

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

# By module of the session, the names that front ends and their tests still import from it. Each
# has to be there: an entry that is no longer needed goes, and none may come.
ALLOWED: dict[str, tuple[str, ...]] = {
    "desks": (
        "FileDesk",
        "LensDesk",
        "PictureDesk",
        "TimeDesk",
    ),
    "exports.export_commands": ("ExportCommands",),
    "exports.export_process": (
        "ExportRun",
        "ExportState",
        "_read_event",
    ),
    "exports.export_settings": (
        "CAMERA_KINDS",
        "ExportSettings",
        "frame_kinds",
        "proposed_settings",
    ),
    "facts": ("Facts",),
    "files": ("folder_walk",),
    "files.file_commands": (
        "FileCommands",
        "PURPOSES",
    ),
    "files.folder_walk": (
        "ChosenFile",
        "FolderWalk",
    ),
    "files.open_reel": ("OpenReel",),
    "files.shot_documents": ("ShotDocuments",),
    "files.start_choices": (
        "Card",
        "word_of",
    ),
    "files.window_door": ("WindowDoor",),
    "keys.key_drag": (
        "KeyDrag",
        "KeyPositions",
        "KeyStretch",
        "Move",
        "nearest_key",
    ),
    "lens.lens_commands": ("KitCommands",),
    "live.pull_recording": ("PullRecording",),
    "live.ring_hand": ("RingHand",),
    "marks": ("mark_measuring",),
    "marks.lessons": (
        "Lesson",
        "Lessons",
    ),
    "marks.mark_commands": ("MarkCommands",),
    "marks.plan": (
        "Plan",
        "PlanDrawer",
        "PlanMark",
    ),
    "pictures": ("picture_commands",),
    "pictures.compare_sides": ("CompareSides",),
    "pictures.live_picture": ("LivePicture",),
    "pictures.picture_commands": ("copy_png",),
    "pictures.ruler": ("Ruler",),
    "playing.cluster_frames": ("ClusterFrames",),
    "scenes.scene_commands": ("SceneCommands",),
    "scenes.size_keeping": ("SizeKeeping",),
    "session": ("Session",),
    "settings.export_place": (
        "ExportPlace",
        "Where",
    ),
    "settings.preferences": (
        "MEGABYTES_MOST",
        "PreferenceValues",
        "Preferences",
        "Theme",
        "WINDOW_LEAST",
    ),
    "shot.editing": ("Editing",),
    "shot.start": ("Start",),
    "speed": ("Speed",),
    "time.timeline": ("Timeline",),
}
NAMES_MOST = 58  # it was 106 in 47 modules; it has to become 0


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
    """Return module and name of all that a source imports from the session."""
    homed = ((homes(module, name), name) for module, name in imports(source))
    return {(home, name) for home, name in homed if f"{home}.".startswith(f"{SESSION}.")}


def names_of_front_ends() -> dict[str, tuple[str, ...]]:
    """Return by module of the session the names that front ends import, both in order."""
    files = [path for folder in FRONT_ENDS for path in folder.rglob("*.py")]
    names = set().union(*(session_names(path.read_text(encoding="utf-8")) for path in files))
    modules = sorted({module for module, _ in names})
    return {
        module.removeprefix(f"{SESSION}."): tuple(sorted(it for at, it in names if at == module))
        for module in modules
    }


def test_front_ends_import_from_the_session_only_what_is_listed():
    assert names_of_front_ends() == ALLOWED


def test_the_list_of_names_does_not_grow():
    assert sum(len(names) for names in ALLOWED.values()) <= NAMES_MOST


def test_a_name_that_the_board_hands_on_counts_as_an_import_of_its_home():
    home = f"{SESSION}.session"
    assert session_names(f"from {BOARD}.board import Session") == {(home, "Session")}
    assert session_names("import heatlens.studio.session.session") == {(home, "")}
    assert (
        session_names(f"from {BOARD}.board import Board\nfrom heatlens.core.base import x") == set()
    )

"""Test that commands and their keys stand in one table: no front end has names or keys of its own.

A front end may draw a button for a command: then its text or call names that one command, and it is
listed here. A key in a sentence has to be the key of a command.
"""

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

import heatlens
from heatlens.studio.ui.state import PANELS
from support.commands import listed_commands

STUDIO = Path(heatlens.__file__).parent / "studio"
TABLES = {"ui/window_commands.py"}  # beside all of the board
NAMES = {command.name for command in listed_commands()} - set(PANELS)  # which name tabs as well
KEYS = {command.key for command in listed_commands()}

# Why a file of a front end has the name of a command, by file and name.
BUTTON = "a button of its own for this command"
HEADING = "the heading of the controls of the same thing"
OWN = "does the same to the page itself, which no command can"
PLACE = "where something is drawn or meant that only this command has"
ALLOWED = {
    "ui/keys_window.py": {"Keys": "the title of the window that the command opens"},
    "ui/layout.py": {"Picture alone": BUTTON, "Open...": PLACE},
    "ui/screen.py": {"Fit": PLACE},
    "ui/panels/looks_panel.py": {"Keep this look": BUTTON},
    "ui/panels/marks_panel.py": {"Set mark here": BUTTON, "Pull focus...": BUTTON},
    "ui/panels/source_panel.py": {"Depth": HEADING},
    "ui/panels/source_rows.py": {"Add clean plate...": BUTTON},
    "ui/panels/rendering_panel.py": {"Speed": HEADING},
    "ui/setting_places.py": {"Speed": "the name of a panel of earlier versions"},
    "ui/panels/scene_panel.py": {"Set camera key": BUTTON},
    "ui/timeline/panel.py": {"Set key": BUTTON},
    "web/index.html": {
        "Play or stop": BUTTON,
        "Previous frame": BUTTON,
        "Next frame": BUTTON,
        "Record a pull": BUTTON,
    },
    "web/looks.js": {"Keep this look": BUTTON, "Back to the lens before": BUTTON},
    "web/main.js": {
        "Open 1/3 stop": BUTTON,
        "Close 1/3 stop": BUTTON,
        "Record a pull": BUTTON,
        "Play or stop": "starts what is recorded",
        "Undo": "drops what was recorded",
        "Fit": OWN,
        "1:1": OWN,
        "Zoom in": OWN,
        "Zoom out": OWN,
    },
    "web/more.js": {
        "Darker": BUTTON,
        "Brighter": BUTTON,
        "Reset exposure and gamma": BUTTON,
        "Picture alone": OWN,
        "Full screen": OWN,
        "Fit": OWN,
    },
    "web/transport.js": {"Play or stop": BUTTON, "Previous frame": BUTTON, "Next frame": BUTTON},
}
_CHORD = r"(?:(?:Ctrl|Shift)\+)+(?:[A-Z0-9]\b|F\d+\b|(?:Up|Down|Left|Right|Space|Delete)\b|[+-])"
_TEXT_OF_PAGE = re.compile(r'"([^"\n]*)"|`([^`]*)`|>\s*([^<>\n]+?)\s*<')
_COMMENT = re.compile(r"/\*.*?\*/|(?<!:)//[^\n]*", re.DOTALL)


def texts_of_python(source: str) -> Iterator[str]:
    """Yield the texts of a module that are no docstrings."""
    tree = ast.parse(source)
    hidden = {id(node.value) for node in ast.walk(tree) if isinstance(node, ast.Expr)}
    for node in ast.walk(tree):
        if isinstance(node, ast.Constant) and isinstance(node.value, str):
            if id(node) not in hidden:
                yield node.value


def texts_of_page(source: str) -> Iterator[str]:
    """Yield the texts of a file of the page, in quotes or between the tags of HTML."""
    for groups in re.findall(
        r'"([^"\n]*)"|`([^`]*)`|>\s*([^<>\n]+?)\s*<', _COMMENT.sub("", source)
    ):
        yield from (text for text in groups if text)


def files_of(folder: str) -> list[Path]:
    paths = sorted((STUDIO / folder).rglob("*"))
    return [path for path in paths if path.suffix in (".py", ".js", ".html")]


def texts_of(path: Path) -> list[str]:
    source = path.read_text(encoding="utf-8")
    return list((texts_of_python if path.suffix == ".py" else texts_of_page)(source))


@pytest.fixture(scope="module")
def texts_by_file() -> dict[str, list[str]]:
    """Return the texts of each file of a front end. To parse them takes seconds."""
    paths = [path for front_end in ("ui", "share", "web") for path in files_of(front_end)]
    names = {str(path.relative_to(STUDIO)): path for path in paths}
    return {name: texts_of(path) for name, path in names.items() if name not in TABLES}


def test_front_ends_name_only_the_listed_commands(texts_by_file):
    found = {name: NAMES & set(texts) for name, texts in texts_by_file.items()}
    assert {name: names for name, names in found.items() if names} == {
        name: set(reasons) for name, reasons in ALLOWED.items()
    }


def test_front_ends_give_no_command_a_key(texts_by_file):
    """The keys alone, such as "Ctrl+Z", stand in the table; sentences may mention them."""
    assert {
        (name, text)
        for name, texts in texts_by_file.items()
        for text in texts
        if re.fullmatch(_CHORD, text)
    } == set()


@pytest.mark.parametrize("folder", ["ui", "session", "share", "web"])
def test_keys_in_sentences_are_keys_of_commands(folder):
    texts = [(path.name, text) for path in files_of(folder) for text in texts_of(path)]
    assert texts
    wrong = {(name, key) for name, text in texts for key in re.findall(_CHORD, text)}
    assert not {(name, key) for name, key in wrong if key not in KEYS}


def test_sample_files_with_a_table_are_detected():
    module = '"""Undo."""\nBUTTONS = {"Undo": ("Ctrl+Z", f"{1} Redo")}\n'
    page = (
        '// "Redo"\nconst KEYS = { "Ctrl+Z": "Undo" };\nconst words = `Shift+L keeps`;\n<b>Fit</b>'
    )
    assert set(texts_of_python(module)) == {"Undo", "Ctrl+Z", " Redo"}
    assert set(texts_of_page(page)) == {"Ctrl+Z", "Undo", "Shift+L keeps", "Fit"}
    assert re.findall(_CHORD, "Ctrl+Shift+click, Shift+M pulls, Ctrl++, Ctrl+F11") == [
        *("Shift+M", "Ctrl++", "Ctrl+F11")
    ]

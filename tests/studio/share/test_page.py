"""The files of the page: they load nothing else, and use the keys and commands of the window."""

import re
from pathlib import Path

import pytest

import heatlens
from heatlens.studio.board.board import Board

WEB = Path(heatlens.__file__).parent / "studio" / "web"
FILES = sorted(WEB.iterdir())
LINES_MOST = 360
LIBRARY = "http://www.w3.org/2000/svg"  # the name of a format, which nothing loads


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.name)
def test_page_file_loads_nothing_from_elsewhere(file):
    text = file.read_text(encoding="utf-8").replace(LIBRARY, "")
    assert not re.search(r"https?://|//cdn|@import|eval\(|innerHTML", text)
    assert len(text.splitlines()) <= LINES_MOST


def test_page_references_exactly_its_files():
    text = "".join(file.read_text(encoding="utf-8") for file in FILES)
    referenced_files = set(re.findall(r'(?:href|src|from) ?=? ?"(?:\./)?([\w.-]+)"', text))
    assert referenced_files | {"index.html"} == {file.name for file in FILES}


def test_page_has_keys_and_buttons_from_the_table_of_commands(session):
    """Its script of keys names no command; its sheet offers those that have a heading."""
    board = Board(session)
    table = board.json_state()["table"]
    assert [name for name, _, _ in table] == [it.name for it in board.remote_commands]
    keyed = {key: name for name, key, sheet in table if key and sheet is not None}
    assert len(keyed) > 25 and keyed["Ctrl+Z"] == "Undo" and "Ctrl+1" not in keyed
    sheets = {sheet for _, _, sheet in table if sheet}
    assert sheets == {"Focus", "Undo", "Over the picture", "Guides", "Units"}
    text = (WEB / "keys.js").read_text(encoding="utf-8")
    assert not [it.name for it in board.commands if f'"{it.name}"' in text]


def test_page_names_only_commands_and_requests_that_it_may_give(session):
    board = Board(session)
    text = "".join(file.read_text(encoding="utf-8") for file in WEB.glob("*.js"))
    named = set(re.findall(r'(?:link\.do|_link\.do)\("([^"]+)"', text))
    assert len(named) > 10
    for name in named:
        board.check_remote({"do": name})

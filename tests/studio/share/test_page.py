"""The files of the page: they load nothing else, and use the keys and commands of the window."""

import re
from pathlib import Path

import pytest

import heatlens
from heatlens.studio.board.board import Board

WEB = Path(heatlens.__file__).parent / "studio" / "web"
FILES = sorted(WEB.iterdir())
PAGE = (WEB / "index.html").read_text(encoding="utf-8")
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


def test_every_button_of_page_has_a_name_and_an_icon_or_words():
    buttons = re.findall(r"<button([^>]*)>(.*?)</button>", PAGE)
    assert len(buttons) > 8
    for attributes, inside in buttons:
        is_drawn = "<svg" in inside
        assert "aria-label" in attributes if is_drawn else inside.strip()


def test_step_buttons_have_no_icon_of_first_and_last():
    """A bar behind the triangle means one step; a bar at its tip means the end of the range."""
    for button, tip_x in (("back", 5), ("forward", 19)):
        (path,) = re.findall(rf'<button id="{button}".*?<path d="([^"]+)"', PAGE)
        triangle, bar = path.rstrip("z").split("z")
        base_x = int(re.findall(r"M(\d+) 5v14", triangle)[0])
        bar_x = int(re.findall(r"M(\d+) 5h3v14", bar)[0])
        assert f"L{tip_x} 12" in triangle or base_x + 9 == tip_x
        assert abs(bar_x - base_x) < abs(bar_x - tip_x)

"""The page as files: what it loads, and that its keys and words are those of the window."""

import re
from pathlib import Path

import pytest

import heatlens
from heatlens.studio.session.door.door import REQUESTS
from heatlens.studio.share.asked import _REQUESTS, shared
from heatlens.studio.ui.menus import items

WEB = Path(heatlens.__file__).parent / "studio" / "web"
FILES = sorted(WEB.iterdir())
LINES_MOST = 360
LIBRARY = "http://www.w3.org/2000/svg"  # the name of a format, which nothing loads


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.name)
def test_nothing_comes_from_elsewhere(file):
    text = file.read_text(encoding="utf-8").replace(LIBRARY, "")
    assert not re.search(r"https?://|//cdn|@import|eval\(|innerHTML", text)
    assert len(text.splitlines()) <= LINES_MOST


def test_every_file_is_used_and_there():
    text = "".join(file.read_text(encoding="utf-8") for file in FILES)
    named = set(re.findall(r'(?:href|src|from) ?=? ?"(?:\./)?([\w.-]+)"', text))
    assert named | {"index.html"} == {file.name for file in FILES}


def commands_of(text: str) -> dict[str, str]:
    return dict(re.findall(r'"(\S+)": "([^"]+)"', text.split("COMMANDS")[1].split("};")[0]))


def test_keys_are_those_of_the_window():
    own = commands_of((WEB / "keys.js").read_text(encoding="utf-8"))
    menus = {item.shortcut: item.name for item in items() if item.shortcut}
    assert len(own) > 25
    assert own.items() <= menus.items()


def test_what_the_page_asks_for_is_allowed():
    text = "".join(file.read_text(encoding="utf-8") for file in WEB.glob("*.js"))
    menus = {item.name: item.menu for item in items()}
    menus |= {f"Matte {name}": "View" for name in ("2.39", "1.85", "16:9", "9:16")}
    rows = text.split("const ROWS")[1].split("];\n")[0]
    asked = set(re.findall(r'(?:link\.do|_link\.do)\("([^"]+)"', text))
    asked |= set(re.findall(r'"([^"]+)"', re.sub(r'\["[^"]+", \[', "", rows))) & menus.keys()
    assert len(asked) > 25
    for name in asked:
        assert name in _REQUESTS or name in shared(), name
    assert set(_REQUESTS) <= REQUESTS.keys()

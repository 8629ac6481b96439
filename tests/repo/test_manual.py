"""Test the manual: short sentences, all keys and options, a picture of each panel it mentions."""

import re

from heatlens.studio.ui.state import PANELS
from manual_keys import PAGE as KEY_PAGE
from manual_keys import key_page
from manual_options import PAGE as OPTION_PAGE
from manual_options import option_page
from support.commands import listed_commands, listed_settings
from support.manual import CONTENTS, MADE_PAGES, MANUAL, manual_text, page, written_pages

LINES_MOST = 200  # of a page
SENTENCE_MOST, PARAGRAPH_MOST, CELL_MOST = 30, 60, 40  # words
README = MANUAL.parents[1] / "README.md"
DEVELOPER_PAGES = (MANUAL.parent / "README.md", MANUAL.parents[1] / "tests" / "README.md")
# A sentence ends at a full stop or colon before a capital letter, code, a link or bold text.
_END = re.compile(r"(?<=[.!?:;])\s+(?=[A-Z`*\[(]|heatlens)")


def paragraphs(text: str) -> list[str]:
    """Return the paragraphs and items of lists; tables, headings, pictures and code are none."""
    text = re.sub(r"```.*?```", "", text, flags=re.DOTALL)
    blocks = re.split(r"\n\s*\n|\n(?=- |\d+\. |#)", re.sub(r"\]\([^)]*\)", "]", text))
    return [it for it in blocks if it.strip() and not it.lstrip().startswith(("|", "#", "!["))]


def cells(text: str) -> list[str]:
    """Return the cells of all tables."""
    rows = re.findall(r"^\|.*\|$", text, re.MULTILINE)
    return [cell for row in rows for cell in re.split(r"(?<!\\)\|", row)]


def sentences(text: str) -> list[str]:
    """Return the sentences of all paragraphs, in which a word stands for each piece of code."""
    words = (re.sub(r"`[^`]*`", "Code", " ".join(it.split())) for it in paragraphs(text))
    return [sentence for it in words for sentence in _END.split(it) if sentence]


def test_sentences_splits_paragraphs_and_lists():
    text = "# Head\n\n- One `a. b` here. Two\n  lines.\n- Three: four; Five.\n\n| a. B | c |\n"
    found_sentences = sentences(text + "\n```\nNo. No.\n```\n")
    assert found_sentences == ["- One Code here.", "Two lines.", "- Three: four;", "Five."]


def test_readme_and_manual_have_short_sentences_paragraphs_and_cells():
    all_pages = README.read_text(encoding="utf-8") + manual_text()
    assert len(sentences(all_pages)) > 300
    assert not [it for it in sentences(all_pages) if len(it.split()) > SENTENCE_MOST]
    assert not [it for it in paragraphs(all_pages) if len(it.split()) > PARAGRAPH_MOST]
    made_pages = "".join(map(page, MADE_PAGES))
    assert not [it for it in cells(all_pages + made_pages) if len(it.split()) > CELL_MOST]


def test_developer_pages_have_short_paragraphs_and_cells():
    text = "\n\n".join(it.read_text(encoding="utf-8") for it in DEVELOPER_PAGES)
    assert len(paragraphs(text)) > 100
    assert not [it for it in paragraphs(text) if len(it.split()) > PARAGRAPH_MOST]
    assert not [it for it in cells(text) if len(it.split()) > CELL_MOST]


def test_every_page_is_in_the_contents_and_short():
    pages = {path.stem for path in MANUAL.glob("*.md")} - {"README"}
    listed = re.findall(r"\]\((\w+)\.md\)", CONTENTS.read_text(encoding="utf-8"))
    assert pages == set(listed) and len(listed) == len(pages)
    lines = {name: len(text.splitlines()) for name, text in written_pages().items()}
    assert lines.keys() == pages - set(MADE_PAGES) and max(lines.values()) <= LINES_MOST


def test_panels_mentioned_in_manual_have_a_picture():
    text = manual_text()
    mentioned_panels = {name for name in PANELS if re.search(rf"\b{name} (tab|panel)\b", text)}
    assert len(mentioned_panels) > 4
    missing = {
        name for name in mentioned_panels if f"assets/manual/{name.lower()}.png)" not in text
    }
    assert not missing


def test_page_of_keys_is_that_of_the_commands():
    """Run `python tests/manual_keys.py` after a change of a command or a key."""
    assert KEY_PAGE.read_text(encoding="utf-8") == key_page(
        (*listed_commands(), *listed_settings())
    )


def test_page_of_options_is_that_of_the_command_line():
    """Run `python tests/manual_options.py` after a change of an option or its help."""
    assert OPTION_PAGE.read_text(encoding="utf-8") == option_page()

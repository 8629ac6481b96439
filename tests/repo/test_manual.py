"""Test the manual: short sentences, all keys and options, a picture of each panel it mentions."""

import re

from heatlens.studio.ui.state import PANELS
from manual_keys import PAGE as KEY_PAGE
from manual_keys import key_page
from manual_options import PAGE as OPTION_PAGE
from manual_options import option_page
from support.commands import listed_commands
from support.manual import CONTENTS, MADE_PAGES, MANUAL, manual_text, written_pages

LINES_MOST = 200  # of a page
WORDS_MOST = 30
# A sentence ends at a full stop or colon before a capital letter, code, a link or bold text.
_END = re.compile(r"(?<=[.!?:;])\s+(?=[A-Z`*\[(]|heatlens)")


def sentences(text: str) -> list[str]:
    """Return the sentences of the paragraphs and lists; tables, headings and code have none."""
    text = re.sub(r"```.*?```", "", text, flags=re.DOTALL)
    blocks = re.split(r"\n\s*\n|\n(?=- )|\n(?=#)", text)
    prose = [block for block in blocks if not block.lstrip().startswith(("|", "#", "!["))]
    all_sentences = []
    for block in prose:
        words = re.sub(r"`[^`]*`", "Code", " ".join(block.split()))
        all_sentences += _END.split(re.sub(r"\]\([^)]*\)", "]", words))
    return [sentence for sentence in all_sentences if sentence]


def test_sentences_splits_paragraphs_and_lists():
    text = "# Head\n\n- One `a. b` here. Two\n  lines.\n- Three: four; Five.\n\n| a. B | c |\n"
    found_sentences = sentences(text + "\n```\nNo. No.\n```\n")
    assert found_sentences == ["- One Code here.", "Two lines.", "- Three: four;", "Five."]


def test_manual_has_no_sentence_above_30_words():
    all_sentences = sentences(manual_text())
    assert len(all_sentences) > 100
    assert not [sentence for sentence in all_sentences if len(sentence.split()) > WORDS_MOST]


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
    assert KEY_PAGE.read_text(encoding="utf-8") == key_page(listed_commands())


def test_page_of_options_is_that_of_the_command_line():
    """Run `python tests/manual_options.py` after a change of an option or its help."""
    assert OPTION_PAGE.read_text(encoding="utf-8") == option_page()

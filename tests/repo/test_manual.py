"""Test the manual: short sentences, all keys and options, a picture of each panel it mentions."""

import re
from pathlib import Path

from heatlens.studio.ui.state import PANELS
from manual_keys import key_table, with_key_table
from manual_options import PAGE, option_page
from support.commands import listed_commands

ROOT = Path(__file__).parents[2]
MANUAL = ROOT / "app" / "MANUAL.md"
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
    all_sentences = sentences(MANUAL.read_text(encoding="utf-8"))
    assert len(all_sentences) > 100
    assert not [sentence for sentence in all_sentences if len(sentence.split()) > WORDS_MOST]


def test_panels_mentioned_in_manual_have_a_picture():
    text = MANUAL.read_text(encoding="utf-8")
    mentioned_panels = {name for name in PANELS if re.search(rf"\b{name} (tab|panel)\b", text)}
    assert len(mentioned_panels) > 4
    missing = {
        name for name in mentioned_panels if f"../assets/manual/{name.lower()}.png)" not in text
    }
    assert not missing


def test_key_table_of_manual_is_that_of_the_commands():
    """Run `python tests/manual_keys.py` after a change of a command or a key."""
    text = MANUAL.read_text(encoding="utf-8")
    commands = listed_commands()
    assert text == with_key_table(text, key_table(commands))
    table = text.partition("| menu | keys |")[2].partition("\n\n")[0]
    for command in commands:
        cell = f"`{command.key}` {command.name}"
        assert (re.search(rf"{re.escape(cell)} (·|\|)", table) is not None) is bool(command.key)


def test_page_of_options_is_that_of_the_command_line():
    """Run `python tests/manual_options.py` after a change of an option or its help."""
    assert PAGE.read_text(encoding="utf-8") == option_page()


def test_new_key_table_replaces_only_the_old_one():
    page = "Before.\n\n| menu | keys |\n| --- | --- |\n| Old | `X` Fly |\n\nAfter.\n\nEnd.\n"
    assert with_key_table(page, "New.\n") == "Before.\n\nNew.\n\nAfter.\n\nEnd.\n"

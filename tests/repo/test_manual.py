"""The manual is easy to read: short sentences, and a picture of each panel that it speaks of."""

import re
from pathlib import Path

from heatlens.studio.ui.state import PANELS

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
    found = []
    for block in prose:
        words = re.sub(r"`[^`]*`", "Code", " ".join(block.split()))
        found += _END.split(re.sub(r"\]\([^)]*\)", "]", words))
    return [sentence for sentence in found if sentence]


def test_sentences_are_found():
    text = "# Head\n\n- One `a. b` here. Two\n  lines.\n- Three: four; Five.\n\n| a. B | c |\n"
    found = sentences(text + "\n```\nNo. No.\n```\n")
    assert found == ["- One Code here.", "Two lines.", "- Three: four;", "Five."]


def test_no_sentence_is_long():
    found = sentences(MANUAL.read_text(encoding="utf-8"))
    assert len(found) > 100
    assert not [sentence for sentence in found if len(sentence.split()) > WORDS_MOST]


def test_panels_that_are_spoken_of_have_a_picture():
    text = MANUAL.read_text(encoding="utf-8")
    spoken = {name for name in PANELS if re.search(rf"\b{name} (tab|panel)\b", text)}
    assert len(spoken) > 4
    missing = {name for name in spoken if f"../assets/manual/{name.lower()}.png)" not in text}
    assert not missing

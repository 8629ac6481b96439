"""Search the pages of the manual by words; each row, item and paragraph is a passage.

Passages are ranked by the words that they share with the question, rare words first (the inverse
document frequency of K. Sparck Jones, 1972), and words of names, headings and bold text most.
"""

import math
import re
import textwrap
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from pathlib import Path

from heatlens.core.base.paths import manual_pages

_REFERENCES = ("keys", "options")  # pages that are lists, made of the program's own records
_NAME_WEIGHT = 3.0  # of a word in bold text, or in the name of the option that it is about
_HEADING_WEIGHT = 1.5  # of a word in a heading, or in the name of another option
_OPTION_WEIGHT = 5.0  # of the only word in the name of an option
_FAMILIAR_LENGTH = 4  # letters that two words share if they are forms of one, such as fast, faster
_FORM_WEIGHT = 0.5  # of a form, beside the word itself
_LONGEST_ENDING = 3  # letters that may follow them
# Words that are too common to tell passages apart.
_STOP_WORDS = frozenset(
    "a an and at do for from how i in is it my of on or the to what where with".split()
)
_HEADS = re.compile(r"^\|.*\n\| ---.*$", re.MULTILINE)  # of tables
_INTRODUCTION = re.compile(r"^\| You have \|.*\n(?:\|.*\n)*", re.MULTILINE)  # is one passage
_LINKS = re.compile(r"(?:\[[^]]*\]\([^)]*\)[ ·]*)+")  # to other pages, and nothing else
_BLOCKS = re.compile(r"\n\s*\n|\n(?=- )|\n(?=\|)|\n(?=#)")


@dataclass(frozen=True)
class Passage:
    """A row of a table, an item of a list or a paragraph, and the headings above it."""

    place: str
    text: str

    def shortened(self, most: int) -> str:
        """Return its beginning, of at most so many characters, without the signs of emphasis."""
        plain = re.sub(r"(\*\*|\*)(\S[^*]*)\1", r"\2", self.text)
        return textwrap.shorten(plain, most, placeholder=" ...")

    @cached_property
    def words(self) -> dict[str, float]:
        """How much each word weighs in it."""
        title, _, sections = self.place.partition(" > ")
        names = " ".join(re.findall(r"\*\*.+?\*\*|^--[\w-]+", self.text))
        options = re.findall(r"^--([a-z]+)(?![\w-])", self.text)
        weights = dict.fromkeys(_words_in(f"{title} {self.text}"), 1.0)
        others = " ".join([sections, *re.findall(r"--[\w-]+", self.text)])
        weights |= dict.fromkeys(_words_in(others), _HEADING_WEIGHT)
        weights |= dict.fromkeys(_words_in(names), _NAME_WEIGHT)
        return weights | dict.fromkeys(options, _OPTION_WEIGHT)


def page_of(passage: Passage) -> Path:
    """Return the page of the manual that holds a passage, by its title."""
    title = f"# {passage.place.partition(' > ')[0]}\n"
    return next(page for page in manual_pages() if page.read_text("utf-8").startswith(title))


@cache
def manual_passages(has_references: bool) -> tuple[Passage, ...]:
    """Return the passages of all pages, with or without the lists of options and of commands."""
    pages = (it for it in manual_pages() if has_references or it.stem not in _REFERENCES)
    return tuple(passage for page in pages for passage in passages_of(page.read_text("utf-8")))


def passages_of(page: str) -> Iterator[Passage]:
    """Yield the passages of a page in Markdown; code, pictures and heads of tables are none.

    The table at its beginning, which says what a user has and wants, is one passage.
    """
    headings: dict[int, str] = {}
    text_only = _HEADS.sub("\n", re.sub(r"```.*?```", "", page, flags=re.DOTALL))
    text_only = _INTRODUCTION.sub(lambda rows: rows[0].replace("|\n|", ";"), text_only)
    for block in _BLOCKS.split(text_only):
        text = " ".join(block.split())
        level = len(text) - len(text.lstrip("#"))
        if level:
            headings = {it: heading for it, heading in headings.items() if it < level}
            headings[level] = text.lstrip("# ")
        elif text and not text.startswith("![") and not _LINKS.fullmatch(text):
            yield Passage(" > ".join(headings.values()), _plain(text))


def best_passages(passages: Iterable[Passage], question: str, most: int) -> Sequence[Passage]:
    """Return the passages that fit a question best, the best one first; none if no word fits."""
    passages = list(passages)
    scores, found_counts = dict.fromkeys(passages, 0.0), dict.fromkeys(passages, 0)
    for word in (it for it in _words_in(question) if it not in _STOP_WORDS):
        fits = {it: weight for it in passages if (weight := _weight_in(it, word))}
        rarity = math.log((1 + len(passages)) / (1 + len(fits)))
        for it, weight in fits.items():
            scores[it] += weight * rarity
            found_counts[it] += 1
    # Of two words, a passage that has both beats one that has a rare one in its heading.
    ranked = {
        it: score * found_counts[it] ** 2 / (2.0 + math.log(1 + len(it.text)))
        for it, score in scores.items()
        if score
    }
    # Several groups list one option with the same words, for different commands.
    best: dict[str, Passage] = {}
    for it in sorted(ranked, key=lambda it: -ranked[it]):
        best.setdefault(it.text.rpartition(": ")[0] or it.text, it)
    return list(best.values())[:most]


def _plain(text: str) -> str:
    """Return the text of a block without the signs of tables, lists and links."""
    if text.startswith("|"):
        text = ": ".join(cell.strip() for cell in re.split(r"(?<!\\)\|", text) if cell.strip())
    text = re.sub(r"\[([^]]*)\]\([^)]*\)", r"\1", text.removeprefix("- "))
    return text.replace("`", "").replace("\\|", "|")


def _words_in(text: str) -> list[str]:
    """Return the words in one spelling: colour is color, centre center, licence license."""
    words = re.findall(r"[a-z0-9]+", text.lower().replace("grey", "gray"))
    return [
        re.sub(r"our(?!n)", "or", re.sub(r"tre(?=s?$)", "ter", it)).replace("enc", "ens")
        for it in words
    ]


def _weight_in(passage: Passage, word: str) -> float:
    """Return how much a passage has of a word: its heaviest word that is it, or a form of it."""
    forms = (
        weight if other == word else _FORM_WEIGHT * weight
        for other, weight in passage.words.items()
        if _is_form(other, word)
    )
    return max(forms, default=0.0)


def _is_form(word: str, other: str) -> bool:
    """Return True for equal words, and for those that differ by a short ending."""
    short, long = sorted((word, other), key=len)
    is_longer = len(short) >= _FAMILIAR_LENGTH and len(long) - len(short) <= _LONGEST_ENDING
    return word == other or (is_longer and long.startswith(short))

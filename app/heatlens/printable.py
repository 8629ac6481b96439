"""Text from files, made safe to show: no name in a file may steer a terminal or forge a line."""

import unicodedata

# Cc: control characters, among them the escape that begins every command of a terminal. Cf holds
# the marks that turn the direction of text, Zl and Zp end a line, Cs is half of a character.
_HIDDEN = frozenset(("Cc", "Cf", "Zl", "Zp", "Cs"))
# Letters of scripts and signs are joined by these two, which do nothing else.
_JOINERS = "\u200c\u200d"


def printable(text: str, keep: str = "") -> str:
    """Return `text` with everything that is not seen written out, as in `\\x1b`; `keep` stays."""
    if text.isascii() and text.isprintable():
        return text
    return "".join(letter if _is_plain(letter, keep) else _escape(letter) for letter in text)


def _is_plain(letter: str, keep: str) -> bool:
    is_seen = unicodedata.category(letter) not in _HIDDEN
    return is_seen or letter in keep or letter in _JOINERS


def _escape(letter: str) -> str:
    """Return the letter as Python writes it in a string."""
    return letter.encode("unicode_escape", "backslashreplace").decode("ascii")


def one_line(said: object, most: int = 160) -> str:
    """Return the first letters of what a library says, without its line breaks."""
    return " ".join(str(said).split())[:most]

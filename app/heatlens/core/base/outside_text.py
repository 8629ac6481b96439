"""Make text from files and networks safe to show, and parse network addresses.

Names in files must not control a terminal or fake a line. The text of a network address is split
into host and port.
"""

import unicodedata
from collections.abc import Sequence
from urllib.parse import urlsplit

# Cc: control characters, including the escape that begins terminal commands. Cf contains the marks
# that change the direction of text, Zl and Zp end a line, Cs is half of a character.
_HIDDEN_CATEGORIES = frozenset(("Cc", "Cf", "Zl", "Zp", "Cs"))
# These two only join letters and signs.
_JOINERS = "\u200c\u200d"


def printable(text: str, keep: str = "") -> str:
    """Return `text` with invisible characters escaped, as in `\\x1b`, except those in `keep`."""
    if text.isascii() and text.isprintable():
        return text
    return "".join(
        letter if _is_shown_unescaped(letter, keep) else _escape(letter) for letter in text
    )


def _is_shown_unescaped(letter: str, keep: str) -> bool:
    """Return True for a letter that is visible, joins others, or is one of `keep`."""
    is_visible = unicodedata.category(letter) not in _HIDDEN_CATEGORIES
    return is_visible or letter in keep or letter in _JOINERS


def _escape(letter: str) -> str:
    """Return the escape sequence of a character, as in a Python string."""
    return letter.encode("unicode_escape", "backslashreplace").decode("ascii")


def one_line(text: object, most: int = 160) -> str:
    """Return the first `most` characters of a library's message, without line breaks."""
    return " ".join(str(text).split())[:most]


def join_first_names(names: Sequence[str], most: int = 8) -> str:
    """Return the first names joined in one line, and how many more there are."""
    count_note = f" and {len(names) - most} more" if len(names) > most else ""
    return ", ".join(names[:most]) + count_note


def host_and_port(text: str) -> tuple[str, int | None]:
    """Split "HOST", "HOST:PORT" or ":PORT"; a missing host is "", a missing port None.

    An IPv6 host stands in brackets. Raises ValueError for any other text.
    """
    parts = urlsplit(f"//{text.strip()}")
    if parts.path or parts.query or parts.fragment or parts.username is not None:
        raise ValueError(text)
    return parts.hostname or "", parts.port

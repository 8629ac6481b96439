"""Take text from outside apart, and make it safe to show.

Names in files must not control a terminal or fake a line. The text of a network address is split
into host and port.
"""

import unicodedata
from collections.abc import Sequence
from urllib.parse import urlsplit

# Cc: control characters, including the escape that begins terminal commands. Cf contains the marks
# that change the direction of text, Zl and Zp end a line, Cs is half of a character.
_HIDDEN = frozenset(("Cc", "Cf", "Zl", "Zp", "Cs"))
# These two only join letters and signs.
_JOINERS = "\u200c\u200d"


def printable(text: str, keep: str = "") -> str:
    """Return `text` with invisible characters escaped, as in `\\x1b`, except those in `keep`."""
    if text.isascii() and text.isprintable():
        return text
    return "".join(letter if _is_plain(letter, keep) else _escape(letter) for letter in text)


def _is_plain(letter: str, keep: str) -> bool:
    is_seen = unicodedata.category(letter) not in _HIDDEN
    return is_seen or letter in keep or letter in _JOINERS


def _escape(letter: str) -> str:
    """Return the escape sequence of a character, as in a Python string."""
    return letter.encode("unicode_escape", "backslashreplace").decode("ascii")


def one_line(text: object, most: int = 160) -> str:
    """Return the first `most` characters of a library's message, without line breaks."""
    return " ".join(str(text).split())[:most]


def shortened(names: Sequence[str], most: int = 8) -> str:
    """Return the first names joined in one line, and how many more there are."""
    more = f" and {len(names) - most} more" if len(names) > most else ""
    return ", ".join(names[:most]) + more


def host_and_port(text: str) -> tuple[str, int | None]:
    """Split "HOST", "HOST:PORT" or ":PORT"; what is not given is "" or None.

    An IPv6 host stands in brackets. Raises ValueError for any other text.
    """
    parts = urlsplit(f"//{text.strip()}")
    if parts.path or parts.query or parts.fragment or parts.username is not None:
        raise ValueError(text)
    return parts.hostname or "", parts.port

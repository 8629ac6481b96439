"""The secret tokens in the addresses: one may turn the lens, one may only look.

They are kept in a file that the user alone may read, so that a link goes on working when the server
is started again.
"""

import hmac
import json
import os
import secrets
import stat
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path

from heatlens.base.paths import file_and_status
from heatlens.files.atomic_file import FOR_THE_USER, write_whole

_TOKEN_BYTES = 16
_TOKEN_LETTERS = len(secrets.token_urlsafe(_TOKEN_BYTES))


class Role(StrEnum):
    """What a link allows."""

    HAND = "hand"  # turn the lens, play, set keys
    LOOK = "look"  # look only


@dataclass(frozen=True)
class Links:
    """The token of each role."""

    hand: str
    look: str

    def role_of(self, token: str) -> Role | None:
        """Return what a token allows; None for a wrong one. Takes the same time for any."""
        given = token.encode("utf-8", "surrogateescape")
        is_hand = hmac.compare_digest(given, self.hand.encode())
        is_look = hmac.compare_digest(given, self.look.encode())
        return Role.HAND if is_hand else Role.LOOK if is_look else None


def new_links() -> Links:
    """Return links with new tokens of 128 bits."""
    return Links(secrets.token_urlsafe(_TOKEN_BYTES), secrets.token_urlsafe(_TOKEN_BYTES))


def kept_links(path: Path, is_new: bool = False) -> Links:
    """Return the links in the file at `path`, or new ones, which are written there.

    `is_new` ends the earlier links. Raises InputError if the file cannot be written.
    """
    kept = None if is_new else _read(path)
    if kept is None:
        kept = new_links()
        path.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
        told = json.dumps({"hand": kept.hand, "look": kept.look})
        write_whole(path, told.encode(), FOR_THE_USER, follows_links=False)
    return kept


def _read(path: Path) -> Links | None:
    """Return the links in a file; None where it is missing, damaged or open to others."""
    try:
        text, status = file_and_status(path)
        told = json.loads(text)
        links = Links(told["hand"], told["look"])
    except (OSError, ValueError, TypeError, KeyError):
        return None
    others = status.st_mode & (stat.S_IRWXG | stat.S_IRWXO)
    is_own = not hasattr(os, "getuid") or (status.st_uid == os.getuid() and not others)
    is_whole = all(
        isinstance(t, str) and t.isascii() and len(t) == _TOKEN_LETTERS
        for t in (links.hand, links.look)
    )
    return links if is_own and is_whole and links.hand != links.look else None

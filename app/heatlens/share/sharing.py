"""Begin and end the sharing of a session, and tell its links."""

import io
from collections.abc import Callable

import segno

from heatlens.base.folders import preferences_dir
from heatlens.share.address import ShareOptions
from heatlens.share.links import Role, kept_links
from heatlens.share.server import ShareServer
from heatlens.share.shared import Shared

_LINKS_FILE = "share.json"


def opened_server(options: ShareOptions, shared: Shared, log: Callable[[str], None]) -> ShareServer:
    """Return a server that listens. Raises InputError with what would help."""
    links = kept_links(preferences_dir() / _LINKS_FILE, options.has_new_links)
    server = ShareServer(options.address, links, shared, log)
    server.start()
    return server


def squares_of(link: str) -> tuple[tuple[bool, ...], ...]:
    """Return the rows of a QR code for a link; True is dark. A quiet border is part of it."""
    rows = segno.make(link, error="l").matrix_iter(border=4)
    return tuple(tuple(bool(square) for square in row) for row in rows)


def code_for_terminal(link: str) -> str:
    """Return a QR code as text of half blocks."""
    text = io.StringIO()
    segno.make(link, error="l").terminal(text, border=2, compact=True)
    return text.getvalue()


def words_of(server: ShareServer) -> tuple[str, str]:
    """Return the two links in words."""
    return (
        f"Turn the lens at   {server.link(Role.HAND)}",
        f"Only look at it at {server.link(Role.LOOK)}",
    )

"""Begin and end the sharing of a session, and return its links.

The libraries that it needs are imported on use, so that a window without them still opens.
"""

import io
from collections.abc import Callable
from typing import TYPE_CHECKING

from heatlens.core.base.extras import extra, import_extra
from heatlens.core.base.paths import preferences_dir
from heatlens.studio.share.address import Role, ShareOptions, load_or_make_links
from heatlens.studio.share.shared import SharedSession

if TYPE_CHECKING:
    from heatlens.studio.share.server import ShareServer

_LINKS_FILE = "share.json"


class Sharing:
    """The server of a session, which is open from `begin` to `end`."""

    def __init__(
        self, options: ShareOptions | None = None, wake: Callable[[], None] = lambda: None
    ) -> None:
        """Create it; `options` apply from `begin` on, None for the defaults.

        Threads call `wake` to make the session's loop turn.
        """
        self._options = options or ShareOptions()
        self.shared = SharedSession(wake)
        self._server: ShareServer | None = None

    def begin(self, log: Callable[[str], None]) -> None:
        """Start the server; `log` gets a line for each client.

        Raises InputError with advice if a package is missing or the address cannot be used.
        """
        import_extra("segno")  # the codes of the links
        with extra("share").require():
            from heatlens.studio.share.server import ShareServer
        links = load_or_make_links(preferences_dir() / _LINKS_FILE, self._options.has_new_links)
        server = ShareServer(self._options.address, links, self.shared, log)
        server.start()
        self._server = server

    def end(self) -> None:
        """End all connections; does nothing if nothing is shared."""
        if self._server is not None:
            self._server.close()
        self._server = None

    @property
    def is_on(self) -> bool:
        """True while a server listens."""
        return self._server is not None

    def link(self, role: Role) -> str:
        """Return the link of a role; "" while nothing is shared."""
        return "" if self._server is None else self._server.link(role)

    def clients_text(self) -> str:
        """Return a text on the user who has the lens, else on the connected clients."""
        turning_count, looking_count = (
            (0, 0) if self._server is None else self._server.count_clients()
        )
        client_text = (
            f"{turning_count} turning, {looking_count} looking"
            if turning_count or looking_count
            else "nobody is here"
        )
        return f"Shared: {self.shared.hands.holder or client_text}"


def qr_code_rows(link: str) -> tuple[tuple[bool, ...], ...]:
    """Return the rows of a QR code for a link; True is dark. A quiet border is part of it."""
    import segno

    rows = segno.make(link, error="l").matrix_iter(border=4)
    return tuple(tuple(bool(square) for square in row) for row in rows)


def qr_code_text(link: str) -> str:
    """Return a QR code as text of half blocks."""
    import segno

    text = io.StringIO()
    segno.make(link, error="l").terminal(text, border=2, compact=True)
    return text.getvalue()

"""Which connections a server keeps, so that nobody fills the room of others.

Whoever has not shown a right link is a stranger. Where strangers are too many, the one that came
first makes room for the next, so a link is always let in. Places of clients are shared between the
addresses that they come from.
"""

import asyncio
from collections import Counter
from collections.abc import Mapping
from typing import TypeVar

from aiohttp import web

STRANGERS_MOST, GUESTS_MOST = 64, 64  # connections without and with a right link, beside clients
REQUEST_S = 5.0  # a connection without a request is closed after this time
KEPT_S = 5.0  # time in which a page may ask again on the same connection

SERVER = "heatlens"  # the header of this name
Place = TypeVar("Place")


class Connection(web.RequestHandler):
    """A connection that tells nobody which programs the server is made of."""

    def handle_error(
        self,
        request: web.BaseRequest,
        status: int = 500,
        exc: BaseException | None = None,
        message: str | None = None,
    ) -> web.StreamResponse:
        """Answer a request that is no HTTP."""
        response = super().handle_error(request, status, exc, message)
        response.headers["Server"] = SERVER
        return response


# 128 idle connections with a wrong link kept every tablet out for an hour. So the oldest stranger
# makes room for a newcomer, a refusal ends its connection, and places are shared between addresses:
# nobody who has a link is kept out by those who have none.
class Connections:
    """The connections that have no place as a client."""

    def __init__(self) -> None:
        self._strangers: dict[Connection, None] = {}  # in the order in which they came
        self._guests: dict[Connection, None] = {}  # they have shown a right link

    def came(self, connection: Connection) -> None:
        """Take a new connection; the first stranger makes room for it."""
        _make_room(self._strangers, STRANGERS_MOST)
        self._strangers[connection] = None

    def showed_link(self, connection: web.RequestHandler) -> None:
        """Take a connection out of the strangers: it has shown a right link."""
        if isinstance(connection, Connection) and connection in self._strangers:
            del self._strangers[connection]
            _make_room(self._guests, GUESTS_MOST)
            self._guests[connection] = None

    def became_client(self, connection: web.RequestHandler) -> None:
        """Leave a connection to the places of clients."""
        if isinstance(connection, Connection):
            self._guests.pop(connection, None)

    def end_stranger(self, connection: Connection) -> None:
        """End a connection if it is still a stranger's."""
        if connection in self._strangers:
            del self._strangers[connection]
            _end(connection)


def _make_room(room: dict[Connection, None], most: int) -> None:
    """Forget connections that are gone, and end the first one of a full room."""
    for gone in [it for it in room if it.transport is None]:
        del room[gone]
    while len(room) >= most:
        first = next(iter(room))
        del room[first]
        _end(first)


def _end(connection: Connection) -> None:
    if isinstance(connection.transport, asyncio.Transport):
        connection.transport.abort()


def giving_way(places: Mapping[Place, str], newcomer: str) -> Place | None:
    """Return which place is freed for somebody from the address `newcomer`; None to refuse him.

    `places` has the addresses of those who are here, the latest last. The latest of the address
    with the most places goes, if it has more than the newcomer's would have.
    """
    counts = Counter(places.values())
    most = max(counts.values(), default=0)
    if most <= counts[newcomer] + 1:
        return None
    return [place for place, address in places.items() if counts[address] == most][-1]

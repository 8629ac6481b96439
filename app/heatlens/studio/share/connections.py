"""Limit the connections of a server, so that nobody takes the places of others.

A connection that has not shown a right link is a stranger, one that has shown it a guest. If there
are too many strangers, the oldest one is ended for a new one; a user with a link can therefore
always connect. Places of clients are shared between the addresses that they come from.
"""

import asyncio
from collections import Counter
from collections.abc import Mapping
from typing import TypeVar

from aiohttp import web

MOST_STRANGERS, MOST_GUESTS = 64, 64  # connections without and with a right link, beside clients
FIRST_REQUEST_S = 5.0  # a connection without a request is closed after this time
KEEP_ALIVE_S = 5.0  # time in which a page may send another request on the same connection

SERVER_HEADER = "heatlens"  # the header of this name
Place = TypeVar("Place")


class Connection(web.RequestHandler):
    """A connection whose error answers do not name the programs that the server is made of."""

    def handle_error(
        self,
        request: web.BaseRequest,
        status: int = 500,
        exc: BaseException | None = None,
        message: str | None = None,
    ) -> web.StreamResponse:
        """Answer a request that is not valid HTTP."""
        response = super().handle_error(request, status, exc, message)
        response.headers["Server"] = SERVER_HEADER
        return response


# Users with a link are not kept out by those without one: the oldest stranger is ended for a new
# connection, a refusal ends its connection, and places are shared between addresses. Without this,
# 128 idle connections with a wrong link kept every tablet out for an hour.
class Connections:
    """The connections that are not clients: strangers and guests."""

    def __init__(self) -> None:
        self._strangers: dict[Connection, None] = {}  # in the order in which they came
        self._guests: dict[Connection, None] = {}  # they have shown a right link

    def add(self, connection: Connection) -> None:
        """Add a new connection as a stranger; end the oldest stranger if there are too many."""
        _limit_connections(self._strangers, MOST_STRANGERS)
        self._strangers[connection] = None

    def mark_as_guest(self, connection: web.RequestHandler) -> None:
        """Make a stranger a guest, because it has shown a right link."""
        if isinstance(connection, Connection) and connection in self._strangers:
            del self._strangers[connection]
            _limit_connections(self._guests, MOST_GUESTS)
            self._guests[connection] = None

    def remove_guest(self, connection: web.RequestHandler) -> None:
        """Remove a guest that has become a client."""
        if isinstance(connection, Connection):
            self._guests.pop(connection, None)

    def end_stranger(self, connection: Connection) -> None:
        """End a connection if it is still a stranger's."""
        if connection in self._strangers:
            del self._strangers[connection]
            _abort(connection)


def _limit_connections(connections: dict[Connection, None], most: int) -> None:
    """Forget closed connections, and end the oldest ones until fewer than `most` are left."""
    for closed in [it for it in connections if it.transport is None]:
        del connections[closed]
    while len(connections) >= most:
        oldest = next(iter(connections))
        del connections[oldest]
        _abort(oldest)


def _abort(connection: Connection) -> None:
    if isinstance(connection.transport, asyncio.Transport):
        connection.transport.abort()


def client_to_replace(places: Mapping[Place, str], newcomer: str) -> Place | None:
    """Return the client that is ended for one from the address `newcomer`; None to refuse that one.

    `places` has the addresses of the present clients, the latest last. The address with the most
    places loses its latest client, if it has more places than the newcomer's address would have.
    """
    counts = Counter(places.values())
    most_places = max(counts.values(), default=0)
    if most_places <= counts[newcomer] + 1:
        return None
    return [place for place, address in places.items() if counts[address] == most_places][-1]

"""Serve the page and its WebSocket on a thread of their own."""

import asyncio
import socket
import ssl
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from importlib import resources
from threading import Event, Thread

from aiohttp import web

from heatlens.core.base.errors import HeatlensError, InputError
from heatlens.core.base.faults import faults_reported
from heatlens.studio.share.address import Address, Links, Role
from heatlens.studio.share.client import Client
from heatlens.studio.share.connections import (
    KEPT_S,
    REQUEST_S,
    SERVER,
    Connection,
    Connections,
    giving_way,
)
from heatlens.studio.share.page_message import MESSAGE_MOST
from heatlens.studio.share.shared import SharedSession

HANDS_MOST, LOOKERS_MOST = 4, 16
_MOST = {Role.HAND: HANDS_MOST, Role.LOOK: LOOKERS_MOST}
_HEARTBEAT_S = 5.0
_START_S = 10.0
_KINDS = {
    "html": "text/html",
    "css": "text/css",
    "js": "text/javascript",
    "svg": "image/svg+xml",
    "webmanifest": "application/manifest+json",
}
_HEADERS = {
    "Server": SERVER,
    "Cache-Control": "no-store",
    "Content-Security-Policy": "default-src 'none'; script-src 'self'; style-src 'self'; "
    "img-src 'self' blob: data:; connect-src 'self' {socket}; manifest-src 'self'; "
    "base-uri 'none'; form-action 'none'; frame-ancestors 'none'",
    "Referrer-Policy": "no-referrer",
    "X-Content-Type-Options": "nosniff",
    "Cross-Origin-Resource-Policy": "same-origin",
}


class ShareServer:
    """A server that is open from `start` to `close`; everything else happens on its thread."""

    def __init__(
        self, address: Address, links: Links, shared: SharedSession, log: Callable[[str], None]
    ) -> None:
        """Prepare a server; `log` gets a line for each client that comes and goes, on a thread."""
        self.address = address
        self.links = links
        self._shared = shared
        self._log = log
        self._files = _page_files()
        self._clients: dict[Client, str] = {}  # with their addresses, the latest last
        self._counted = 0
        self._connections = Connections()
        self._end = asyncio.Event()
        self._thread = Thread(target=self._run, name="share", daemon=True)
        self._is_up = Event()
        self._problem: Exception | None = None
        self.port = 0

    # For the session's thread

    def start(self) -> None:
        """Begin to listen. Raises InputError if the address cannot be listened on."""
        self._tls = self.address.tls()
        self._socket = _listening(self.address)
        self.port = self._socket.getsockname()[1]
        self._hosts = self.address.hosts(self.port)
        self._origins = {f"{self.address.scheme}://{host}" for host in self._hosts}
        web_socket = self.address.url(self.port).replace("http", "ws", 1).rstrip("/")
        self._headers = {name: value.format(socket=web_socket) for name, value in _HEADERS.items()}
        self._loop = asyncio.new_event_loop()
        # One thread encodes: each further one would keep memory of its own, and wait for the first.
        # Measured with 120 pictures of 1920x1080 in three sizes: 144 MB with six threads, 95 MB
        # with one.
        self._loop.set_default_executor(ThreadPoolExecutor(1, thread_name_prefix="encoder"))
        self._shared.announce = self._announce
        self._thread.start()
        self._is_up.wait(_START_S)
        if self._problem is not None:
            raise InputError(f"The server could not start: {self._problem}.") from self._problem

    def link(self, role: Role) -> str:
        """Return the address that somebody opens."""
        return self.address.url(self.port, getattr(self.links, role))

    def who(self) -> tuple[int, int]:
        """Return the numbers of clients that may turn the lens, and of those that only look."""
        roles = [client.role for client in list(self._clients)]
        return roles.count(Role.HAND), roles.count(Role.LOOK)

    def close(self) -> None:
        """End the connections, and stop listening."""
        self._shared.announce = lambda: None
        if self._thread.is_alive():
            with suppress(RuntimeError):  # it has ended meanwhile
                self._loop.call_soon_threadsafe(self._end.set)
            self._thread.join(_START_S)
        self._shared.clients = self._shared.waiting = 0

    def _announce(self) -> None:
        with suppress(RuntimeError):  # it ends at this moment
            self._loop.call_soon_threadsafe(self._tell_clients)

    # On the server's thread

    def _run(self) -> None:
        asyncio.set_event_loop(self._loop)
        try:
            self._loop.run_until_complete(self._serve(self._socket, self._tls))
        except OSError as error:
            self._problem = error
        finally:
            self._is_up.set()
            self._loop.close()

    async def _serve(self, listening: socket.socket, tls: ssl.SSLContext | None) -> None:
        self._server = web.Server(self._answer, access_log=None)
        runner = web.ServerRunner(self._server, handle_signals=False, shutdown_timeout=1.0)
        await runner.setup()
        server = await self._loop.create_server(self._connected, sock=listening, ssl=tls)
        self._is_up.set()
        await self._end.wait()
        server.close()
        for client in list(self._clients):
            await client.part("Sharing has ended.", code=1001)
        await runner.cleanup()

    def _connected(self) -> asyncio.Protocol:
        """Return the handler of a new connection, which is closed if it sends no request."""
        connection = Connection(self._server, loop=self._loop, keepalive_timeout=KEPT_S)
        self._connections.came(connection)
        self._loop.call_later(REQUEST_S, self._connections.end_stranger, connection)
        return connection

    async def _answer(self, request: web.BaseRequest) -> web.StreamResponse:
        """Answer a request; after a fault of the program, say so and write a report."""
        try:
            with faults_reported("A request could not be answered"):
                return await self._answered(request)
        except HeatlensError as error:
            self._log(str(error))
            return self._refusal(500, "This could not be answered.")

    async def _answered(self, request: web.BaseRequest) -> web.StreamResponse:
        """Answer a request that is meant for this server and has a right token."""
        if request.headers.get("Host", "").lower() not in self._hosts:
            return self._refusal(421, "This address is not the one that is shared.")
        origin = request.headers.get("Origin")
        if origin is not None and origin.lower() not in self._origins:
            return self._refusal(403, "Pages of other addresses may not connect.")
        _, _, rest = request.path.partition("/")
        token, _, name = rest.partition("/")
        role = self.links.role_of(token)
        if role is None:
            return self._refusal(404, "This link is wrong, or no longer shared.")
        self._connections.showed_link(request.protocol)
        if request.method != "GET":
            return self._refusal(405, "Only GET is answered.")
        if name == "socket":
            return await self._talk(request, role)
        return self._file(name or "index.html")

    def _file(self, name: str) -> web.StreamResponse:
        """Return a file of the page; all of them were read when the server was made."""
        content = self._files.get(name)
        if content is None:
            return self._refusal(404, "The page has no such file.")
        kind = _KINDS[name.rpartition(".")[2]]
        return web.Response(body=content, content_type=kind, charset="utf-8", headers=self._headers)

    def _refusal(self, status: int, sentence: str) -> web.Response:
        """Refuse a request, and end its connection."""
        response = web.Response(status=status, text=f"{sentence}\n", headers=self._headers)
        response.force_close()
        return response

    async def _talk(self, request: web.BaseRequest, role: Role) -> web.StreamResponse:
        """Serve a WebSocket until it closes."""
        where = _address_of(request)
        if not await self._has_place(role, where):
            most = _MOST[role]
            return self._refusal(503, f"There are {most} of this kind already.")
        if not web.WebSocketResponse().can_prepare(request):
            return self._refusal(426, "This is the place of a WebSocket.")
        self._connections.became_client(request.protocol)
        socket = web.WebSocketResponse(
            heartbeat=_HEARTBEAT_S, max_msg_size=MESSAGE_MOST, compress=False
        )
        socket.headers["Server"] = SERVER
        self._counted += 1
        client = Client(socket, request.transport, role, self._counted, self._shared)
        self._clients[client] = where
        try:
            with suppress(ConnectionError):  # the client has gone, which is no fault of ours
                await socket.prepare(request)
                await client.serve(self._count, self._log)
        finally:
            self._clients.pop(client, None)
            self._count()
            if client.greeted:
                self._log(f"{client.name} has gone.")
        return socket

    async def _has_place(self, role: Role, where: str) -> bool:
        """Return True if there is a place; another address with more of them may free one."""
        here = {it: address for it, address in self._clients.items() if it.role is role}
        if len(here) < _MOST[role]:
            return True
        leaving = giving_way(here, where)
        if leaving is not None:
            del self._clients[leaving]
            await leaving.part("Others have no place: there are many from this address.")
        return leaving is not None

    def _count(self) -> None:
        """Tell the loop how many clients there are, and how many can take a picture."""
        here = [client for client in self._clients if client.greeted]
        is_other = len(here) != self._shared.clients
        self._shared.clients = len(here)
        self._shared.waiting = sum(client.is_ready for client in here)
        if is_other or self._shared.is_behind:
            self._shared.wake()

    def _tell_clients(self) -> None:
        for client in self._clients:
            client.announce()


def _address_of(request: web.BaseRequest) -> str:
    where = None if request.transport is None else request.transport.get_extra_info("peername")
    return str(where[0]) if where else ""


def _page_files() -> dict[str, bytes]:
    """Return the files of the page by name."""
    folder = resources.files("heatlens") / "studio" / "web"
    names = [it.name for it in folder.iterdir() if it.name.rpartition(".")[2] in _KINDS]
    return {name: (folder / name).read_bytes() for name in names}


def _listening(address: Address) -> socket.socket:
    """Return a socket that listens at the address. Raises InputError."""
    family = socket.AF_INET6 if ":" in address.host else socket.AF_INET
    try:
        return socket.create_server((address.host, address.port), family=family)
    except (OSError, UnicodeError, OverflowError) as error:
        reason = getattr(error, "strerror", None) or error
        raise InputError(
            f"Cannot share on {address.host}:{address.port} ({reason}): give an address of this "
            "machine, or another port, such as 127.0.0.1:8871; port 0 takes a free one."
        ) from error

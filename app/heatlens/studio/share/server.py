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
from heatlens.core.base.faults import report_faults
from heatlens.studio.share.address import Address, Links, Role
from heatlens.studio.share.client import Client
from heatlens.studio.share.connections import (
    FIRST_REQUEST_S,
    KEEP_ALIVE_S,
    SERVER_HEADER,
    Connection,
    Connections,
    client_to_replace,
)
from heatlens.studio.share.page_message import MESSAGE_MOST
from heatlens.studio.share.shared import SharedSession

MOST_HANDS, MOST_LOOKERS = 4, 16
_MOST_CLIENTS = {Role.HAND: MOST_HANDS, Role.LOOK: MOST_LOOKERS}
_HEARTBEAT_S = 5.0
_START_S = 10.0
_CONTENT_TYPES = {
    "html": "text/html",
    "css": "text/css",
    "js": "text/javascript",
    "svg": "image/svg+xml",
    "webmanifest": "application/manifest+json",
}
_HEADERS = {
    "Server": SERVER_HEADER,
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
        self._files = _read_page_files()
        self._clients: dict[Client, str] = {}  # with their addresses, the latest last
        self._client_number = 0
        self._connections = Connections()
        self._end_event = asyncio.Event()
        self._thread = Thread(target=self._run, name="share", daemon=True)
        self._started_event = Event()
        self._problem: Exception | None = None
        self.port = 0

    # For the session's thread

    def start(self) -> None:
        """Begin to listen. Raises InputError if the address cannot be listened on."""
        self._tls = self.address.tls()
        self._socket = _listening_socket(self.address)
        self.port = self._socket.getsockname()[1]
        self._hosts = self.address.hosts(self.port)
        self._origins = {f"{self.address.scheme}://{host}" for host in self._hosts}
        web_socket = self.address.url(self.port).replace("http", "ws", 1).rstrip("/")
        self._headers = {name: value.format(socket=web_socket) for name, value in _HEADERS.items()}
        self._loop = asyncio.new_event_loop()
        # One thread encodes pictures: each further one would keep memory of its own, and wait for
        # the first. Measured with 120 pictures of 1920x1080 in three sizes: 144 MB with six
        # threads, 95 MB with one.
        self._loop.set_default_executor(ThreadPoolExecutor(1, thread_name_prefix="encoder"))
        self._shared.listen(self._announce)
        self._thread.start()
        self._started_event.wait(_START_S)
        if self._problem is not None:
            raise InputError(f"The server could not start: {self._problem}.") from self._problem

    def link(self, role: Role) -> str:
        """Return the address that somebody opens."""
        return self.address.url(self.port, getattr(self.links, role))

    def count_clients(self) -> tuple[int, int]:
        """Return the numbers of clients that may turn the lens, and of those that only look."""
        roles = [client.role for client in list(self._clients)]
        return roles.count(Role.HAND), roles.count(Role.LOOK)

    def close(self) -> None:
        """End the connections, and stop listening."""
        self._shared.stop_listening()
        if self._thread.is_alive():
            with suppress(RuntimeError):  # it has ended meanwhile
                self._loop.call_soon_threadsafe(self._end_event.set)
            self._thread.join(_START_S)
        self._shared.client_count = self._shared.ready_clients = 0

    def _announce(self) -> None:
        """Notify the clients on the server's thread that there is a new state or picture."""
        with suppress(RuntimeError):  # it ends at this moment
            self._loop.call_soon_threadsafe(self._wake_clients)

    # On the server's thread

    def _run(self) -> None:
        """Serve until `close` is called; runs on the server's thread."""
        asyncio.set_event_loop(self._loop)
        try:
            self._loop.run_until_complete(self._serve(self._socket, self._tls))
        except OSError as error:
            self._problem = error
        finally:
            self._started_event.set()
            self._loop.close()

    async def _serve(self, listening_socket: socket.socket, tls: ssl.SSLContext | None) -> None:
        self._server = web.Server(self._answer_or_report, access_log=None)
        runner = web.ServerRunner(self._server, handle_signals=False, shutdown_timeout=1.0)
        await runner.setup()
        server = await self._loop.create_server(
            self._new_connection, sock=listening_socket, ssl=tls
        )
        self._started_event.set()
        await self._end_event.wait()
        server.close()
        for client in list(self._clients):
            await client.disconnect("Sharing has ended.", code=1001)
        await runner.cleanup()

    def _new_connection(self) -> asyncio.Protocol:
        """Return the handler of a new connection, which is closed if it sends no request."""
        connection = Connection(self._server, loop=self._loop, keepalive_timeout=KEEP_ALIVE_S)
        self._connections.add(connection)
        self._loop.call_later(FIRST_REQUEST_S, self._connections.end_stranger, connection)
        return connection

    async def _answer_or_report(self, request: web.BaseRequest) -> web.StreamResponse:
        """Answer a request; after a fault of the program, answer with an error and report it."""
        try:
            with report_faults("A request could not be answered"):
                return await self._answer_request(request)
        except HeatlensError as error:
            self._log(str(error))
            return self._refusal(500, "This could not be answered.")

    async def _answer_request(self, request: web.BaseRequest) -> web.StreamResponse:
        """Answer a request that is meant for this server and has a right token."""
        if request.headers.get("Host", "").lower() not in self._hosts:
            return self._refusal(421, "This address is not the one that is shared.")
        origin = request.headers.get("Origin")
        if origin is not None and origin.lower() not in self._origins:
            return self._refusal(
                403,
                "Open the link itself in the browser: pages of other addresses may not connect.",
            )
        _, _, path = request.path.partition("/")
        token, _, name = path.partition("/")
        role = self.links.role_of(token)
        if role is None:
            return self._refusal(404, "This link is wrong, or no longer shared.")
        self._connections.mark_as_guest(request.protocol)
        if request.method != "GET":
            return self._refusal(405, "Only GET is answered.")
        if name == "socket":
            return await self._serve_web_socket(request, role)
        return self._file(name or "index.html")

    def _file(self, name: str) -> web.StreamResponse:
        """Return a file of the page; all of them were read when the server was made."""
        content = self._files.get(name)
        if content is None:
            return self._refusal(404, "The page has no such file.")
        content_type = _CONTENT_TYPES[name.rpartition(".")[2]]
        return web.Response(
            body=content, content_type=content_type, charset="utf-8", headers=self._headers
        )

    def _refusal(self, status: int, message: str) -> web.Response:
        """Refuse a request, and end its connection."""
        response = web.Response(status=status, text=f"{message}\n", headers=self._headers)
        response.force_close()
        return response

    async def _serve_web_socket(self, request: web.BaseRequest, role: Role) -> web.StreamResponse:
        """Serve a WebSocket until it closes."""
        client_address = _client_address(request)
        if not await self._free_place(role, client_address):
            limit = _MOST_CLIENTS[role]
            return self._refusal(
                503, f"There are {limit} pages of this kind already: close one of them."
            )
        if not web.WebSocketResponse().can_prepare(request):
            return self._refusal(426, "This is the place of a WebSocket.")
        self._connections.remove_guest(request.protocol)
        socket = web.WebSocketResponse(
            heartbeat=_HEARTBEAT_S, max_msg_size=MESSAGE_MOST, compress=False
        )
        socket.headers["Server"] = SERVER_HEADER
        self._client_number += 1
        client = Client(socket, request.transport, role, self._client_number, self._shared)
        self._clients[client] = client_address
        try:
            with suppress(ConnectionError):  # the client has gone, which is no fault of ours
                await socket.prepare(request)
                await client.serve(self._publish_client_counts, self._log)
        finally:
            self._clients.pop(client, None)
            self._publish_client_counts()
            if client.is_greeted:
                self._log(f"{client.name} has gone.")
        return socket

    async def _free_place(self, role: Role, client_address: str) -> bool:
        """Return True if a new client gets a place.

        If all are taken, a client of an address with more places is ended for it.
        """
        clients = {it: address for it, address in self._clients.items() if it.role is role}
        if len(clients) < _MOST_CLIENTS[role]:
            return True
        replaced = client_to_replace(clients, client_address)
        if replaced is not None:
            del self._clients[replaced]
            await replaced.disconnect("Others have no place: there are many from this address.")
        return replaced is not None

    def _publish_client_counts(self) -> None:
        """Publish to the loop how many clients there are and can take a picture; wake it."""
        clients = [client for client in self._clients if client.is_greeted]
        has_changed = len(clients) != self._shared.client_count
        self._shared.client_count = len(clients)
        self._shared.ready_clients = sum(client.is_ready for client in clients)
        if has_changed or self._shared.is_behind:
            self._shared.wake()

    def _wake_clients(self) -> None:
        for client in self._clients:
            client.wake()


def _client_address(request: web.BaseRequest) -> str:
    """Return the IP address of a client; "" if it has gone."""
    peer = None if request.transport is None else request.transport.get_extra_info("peername")
    return str(peer[0]) if peer else ""


def _read_page_files() -> dict[str, bytes]:
    """Return the files of the page by name."""
    folder = resources.files("heatlens") / "studio" / "web"
    names = [it.name for it in folder.iterdir() if it.name.rpartition(".")[2] in _CONTENT_TYPES]
    return {name: (folder / name).read_bytes() for name in names}


def _listening_socket(address: Address) -> socket.socket:
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

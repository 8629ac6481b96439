"""Frames from a running renderer: listens as the viewer tev does, and keeps the images it is sent.

One thread does it all. Whoever connects is a stranger: nothing it sends can raise here, make a file
be read, or take more memory than the bounds say.
"""

import selectors
import socket
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from threading import Lock, Thread

from heatlens.closing import Closing
from heatlens.errors import InputError
from heatlens.model.plate_options import PlateOptions
from heatlens.plate.plate import Plate
from heatlens.stream.images import TevImage, TevImages
from heatlens.stream.protocol import (
    PacketStream,
    ReadFile,
    TevPacketError,
    TevStreamError,
    message_of,
)
from heatlens.stream.received_plate import chosen_channels, plate_of_image

DEFAULT_HOST = "127.0.0.1"  # this machine alone, because the protocol has no password
DEFAULT_PORT = 14158

MAX_CLIENTS = 16
MAX_HELD_BYTES = 1 << 29  # of packets not yet whole, of all clients together
NEWS_A_SECOND = 20  # at most; a renderer may send thousands of tiles

_READ_BYTES = 1 << 18


@dataclass(eq=False)
class _Client:
    """A connection, its unfinished packet, and when it was last heard."""

    socket: socket.socket
    stream: PacketStream = field(default_factory=PacketStream)
    heard_s: float = field(default_factory=time.monotonic)


def parse_address(text: str) -> tuple[str, int]:
    """Parse "[HOST:]PORT"; an IPv6 host stands in brackets, no host means this machine.

    An IPv6 host stands in brackets. Port 0 takes a free one. Raises InputError for anything else.
    """
    host, colon, port = text.strip().rpartition(":")
    if host.startswith("[") and host.endswith("]"):
        host = host[1:-1]
    elif ":" in host:
        host, colon = "", ":"  # an IPv6 address without brackets: its end is no port
    if (colon and not host) or not (port.isascii() and port.isdigit() and int(port) < 65536):
        raise InputError(
            f"{text!r} is not an address to listen on: give PORT or HOST:PORT, such as "
            f"{DEFAULT_PORT} or 0.0.0.0:{DEFAULT_PORT}."
        )
    return host or DEFAULT_HOST, int(port)


class TevServer(Closing):
    """Listens until `close`; its methods may be called from any thread."""

    def __init__(
        self,
        host: str = DEFAULT_HOST,
        port: int = DEFAULT_PORT,
        on_news: Callable[[], None] | None = None,
        images: TevImages | None = None,
    ) -> None:
        """Listen at `host`:`port`.

        `on_news` is called on the server's thread after `version` went up or a packet was dropped
        or refused. Raises InputError where the address cannot be used.
        """
        self._listener = _listening(host, port)
        self.address: tuple[str, int] = self._listener.getsockname()[:2]
        self.version = 0  # goes up when images changed
        self.dropped = 0  # packets that were invalid or did not fit
        self.refused = 0  # packets that asked to read a file of this machine
        self.fault: str | None = None  # why the last of them was dropped or refused, a sentence
        self._on_news = on_news
        self._images = TevImages() if images is None else images
        self._lock = Lock()  # over the images
        self._snapshot_problem: str | None = None
        self._clients: list[_Client] = []
        self._changed = self._has_news = False
        self._told_s = -1.0
        self._wake, self._waker = socket.socketpair()
        self._selector = selectors.DefaultSelector()
        self._selector.register(self._listener, selectors.EVENT_READ)
        self._selector.register(self._wake, selectors.EVENT_READ)
        self._thread = Thread(target=self._serve, name="tev-server", daemon=True)
        self._thread.start()

    @property
    def names(self) -> tuple[str, ...]:
        """The images there are, the one created last in front."""
        with self._lock:
            return self._images.names

    @property
    def problem(self) -> str | None:
        """Why the last `snapshot` gave no plate, or why none can yet, in a sentence; else None."""
        if not self.names:
            host, port = self.address
            said = f" {self.fault}" if self.fault else ""
            return f"No image has arrived at {host}:{port} yet.{said}"
        return self._snapshot_problem

    def snapshot(
        self, name: str | None = None, options: PlateOptions | None = None
    ) -> Plate | None:
        """Return a plate of the image `name` as it is now; None where it makes none.

        `problem` then says why. Without a name it is the image created last that has colour and
        depth.
        """
        self._snapshot_problem = None
        options = options or PlateOptions()
        try:
            image, aovs = self._copy_of(self.names if name is None else (name,), options)
            return plate_of_image(image, options, aovs)
        except InputError as error:
            self._snapshot_problem = str(error)
            return None

    def close(self) -> None:
        """End every connection and the thread; a second call does nothing."""
        if self._thread.is_alive():
            self._waker.send(b"x")
            self._thread.join()
        self._waker.close()

    def _copy_of(
        self, names: tuple[str, ...], options: PlateOptions
    ) -> tuple[TevImage, tuple[str, ...]]:
        """Copy what a plate needs of the first image that has the channels for one.

        Returns it with the names of all its channels. Raises InputError, about the first image,
        where none has them.
        """
        why_not = None
        for name in names:
            with self._lock:
                image = self._images.get(name)
                try:
                    if image is not None:
                        return chosen_channels(image, options), tuple(image.planes)
                except InputError as error:
                    why_not = why_not or error
        wanted = f"image {names[0]!r}" if names else "image"
        raise why_not or InputError(f"No {wanted} has arrived yet.")

    def _serve(self) -> None:
        try:
            while self._serve_once():
                self._tell_news()
        finally:
            for client in tuple(self._clients):
                self._hang_up(client)
            self._selector.close()
            self._listener.close()
            self._wake.close()

    def _serve_once(self) -> bool:
        """Wait for the next event and handle it; return False when the server is to end."""
        for key, _ in self._selector.select(self._pause_s()):
            if key.fileobj is self._wake:
                return False
            if key.fileobj is self._listener:
                self._accept()
            elif key.data in self._clients:  # unless it was disconnected meanwhile
                self._hear(key.data)
        return True

    def _accept(self) -> None:
        """Accept a client; the one silent for the longest time makes room."""
        try:
            connection, _ = self._listener.accept()
        except OSError as error:  # the client left again, or no file handle is free
            self._say(f"A connection could not be taken ({error.strerror}).")
            time.sleep(1 / NEWS_A_SECOND)  # the client may still be waiting; do not spin
            return
        if len(self._clients) >= MAX_CLIENTS:
            self._hang_up(min(self._clients, key=lambda client: client.heard_s))
        connection.setblocking(False)
        client = _Client(connection)
        self._clients.append(client)
        self._selector.register(connection, selectors.EVENT_READ, client)

    def _hear(self, client: _Client) -> None:
        """Read what `client` has sent, up to the end of one packet."""
        try:
            chunk = client.socket.recv(min(client.stream.wanted, _READ_BYTES))
        except BlockingIOError:
            return
        except OSError:  # the renderer may close its connection at any time
            chunk = b""
        if not chunk:
            self._hang_up(client)
            return
        client.heard_s = time.monotonic()
        try:
            packet = client.stream.feed(chunk)
        except TevStreamError as error:
            self._drop(str(error))
            self._hang_up(client)
            return
        if packet is not None:
            self._take(packet)
        elif sum(one.stream.held for one in self._clients) > MAX_HELD_BYTES:
            self._drop("the packets of all clients are too large together")
            self._hang_up(client)

    def _take(self, packet: bytearray) -> None:
        try:
            message = message_of(packet)
            if isinstance(message, ReadFile):
                self.refused += 1
                self._say(f"A client asked for the file {message.name[:200]!r}: none is read.")
                return
            with self._lock:
                self._changed |= self._images.apply(message)
        except TevPacketError as error:
            self._drop(str(error))
        except MemoryError:
            self._drop("this machine has no memory for its image")

    def _drop(self, why: str) -> None:
        self.dropped += 1
        self._say(f"A packet was dropped: {why}.")

    def _say(self, fault: str) -> None:
        self.fault = fault
        self._has_news = True

    def _pause_s(self) -> float | None:
        """Return the seconds until delayed news are due; None without any."""
        if not (self._changed or self._has_news):
            return None
        return max(0.0, self._told_s + 1 / NEWS_A_SECOND - time.monotonic())

    def _tell_news(self) -> None:
        if self._pause_s() != 0.0:
            return
        self.version += self._changed
        self._changed = self._has_news = False
        self._told_s = time.monotonic()
        if self._on_news is not None:
            self._on_news()

    def _hang_up(self, client: _Client) -> None:
        self._clients.remove(client)
        self._selector.unregister(client.socket)
        client.socket.close()


def _listening(host: str, port: int) -> socket.socket:
    """Return a socket that waits for clients at `host`:`port`."""
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    try:
        listener = socket.create_server((host, port), family=family)
    except (OSError, UnicodeError) as error:
        reason = getattr(error, "strerror", None) or error
        raise InputError(
            f"Cannot listen on {host}:{port} ({reason}): give another port or the address of this "
            "machine; tev itself, or another heatlens, may be there already."
        ) from error
    listener.setblocking(False)
    return listener

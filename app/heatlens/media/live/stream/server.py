"""Receive frames from a running renderer: listen like the viewer tev, and keep the images.

One thread does all the work. Clients are not trusted: nothing that they send can raise an error
here or take more memory than the limits allow. A picture file is read at the request of a client
only if the client runs on this machine, and so could read it itself.
"""

import selectors
import socket
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from threading import Lock, Thread

from heatlens.core.base.closing import Closing
from heatlens.core.base.errors import InputError
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.media.live.stream.address import DEFAULT_HOST, DEFAULT_PORT, listening_socket
from heatlens.media.live.stream.chosen_image import ChosenImage, choose_image
from heatlens.media.live.stream.images import TevImages
from heatlens.media.live.stream.protocol import (
    MAX_CHANNELS,
    CloseImage,
    CreateImage,
    Message,
    PacketStream,
    ReadFile,
    TevPacketError,
    TevStreamError,
    parse_message,
)
from heatlens.media.live.stream.received_plate import (
    LENS_IMAGE,
    lens_header,
    plate_of_image,
    replace_sent_values,
)
from heatlens.media.live.stream.requested_file import check_requested_file, is_from_this_machine
from heatlens.media.plate.plate import Plate
from heatlens.media.plate.read import read_plate

MAX_CLIENTS = 16
MAX_BUFFERED_BYTES = 1 << 29  # for the unfinished packets of all clients together
NOTIFICATIONS_A_SECOND = 20  # most notifications; a renderer may send thousands of tiles

_READ_BYTES = 1 << 18


@dataclass(eq=False)
class _Client:
    """A connection, its unfinished packet, and the time at which it last sent bytes."""

    socket: socket.socket
    stream: PacketStream = field(default_factory=PacketStream)
    last_received_s: float = field(default_factory=time.monotonic)


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
        or refused. Raises InputError if the address cannot be used.
        """
        self._listener = listening_socket(host, port)
        self.address: tuple[str, int] = self._listener.getsockname()[:2]
        self.version = 0  # increases when images change
        self.dropped = 0  # packets that were invalid or did not fit
        self.refused = 0  # requests for a file that must not be read
        self.left_s: float | None = None  # time of the clock at which the last client left
        self.fault: str | None = None  # a sentence on the last packet that was dropped or refused
        self._on_news = on_news
        self._images = TevImages() if images is None else images
        self._lens = TevImages(max_images=1, max_values=MAX_CHANNELS)
        self._file: Path | None = None  # the file of the last request, if a file was requested
        self._lock = Lock()  # guards the images, the lens and the file
        self._snapshot_problem: str | None = None
        self._clients: list[_Client] = []
        self._has_changed_images = self._has_new_fault = False
        self._last_notified_s = -1.0
        self._wake, self._waker = socket.socketpair()
        self._selector = selectors.DefaultSelector()
        self._selector.register(self._listener, selectors.EVENT_READ)
        self._selector.register(self._wake, selectors.EVENT_READ)
        self._thread = Thread(target=self._serve, name="tev-server", daemon=True)
        self._thread.start()

    @property
    def names(self) -> tuple[str, ...]:
        """The names of the images, the newest first."""
        with self._lock:
            return self._images.names

    @property
    def problem(self) -> str | None:
        """A sentence on why the newest image, or any at all, cannot be shown; else None."""
        with self._lock:
            is_empty = not self._images.names and self._file is None
        if is_empty:
            host, port = self.address
            fault_note = f" {self.fault}" if self.fault else ""
            return f"No image has arrived at {host}:{port} yet.{fault_note}"
        return self._snapshot_problem

    def snapshot(
        self, name: str | None = None, options: PlateOptions | None = None
    ) -> Plate | None:
        """Return a plate of the current image `name`; None if no plate can be made of it.

        Without a name, use the file that a client requested last, or the newest image that has
        color and depth. If that is not the newest image, `problem` says why.
        """
        self._snapshot_problem = None
        options = options or PlateOptions()
        try:
            with self._lock:  # the next packet may withdraw the file
                file = self._file
            if file is not None and name is None:
                return self._plate_of_file(file, options)
            chosen_copy, lens = self._copy_chosen_image(name, options)
            plate = plate_of_image(chosen_copy, options, lens)
            self._snapshot_problem = chosen_copy.skipped_note or None
        except InputError as error:
            self._snapshot_problem = str(error)
            return None
        return plate

    def close(self) -> None:
        """End every connection and the thread; a second call does nothing."""
        if self._thread.is_alive():
            self._waker.send(b"x")
            self._thread.join()
        self._waker.close()

    def _plate_of_file(self, path: Path, options: PlateOptions) -> Plate:
        """Return the plate of a requested file, with the lens that a client has sent."""
        plate = read_plate(path, options)
        with self._lock:
            sent_header = lens_header(self._lens.get(LENS_IMAGE))
        return replace(plate, camera=replace_sent_values(plate.camera, sent_header))

    def _copy_chosen_image(
        self, name: str | None, options: PlateOptions
    ) -> tuple[ChosenImage, Mapping[str, object]]:
        """Copy the channels that a plate needs, and the header entries of its lens.

        Raises InputError if no image has the channels for a plate.
        """
        with self._lock:
            names = self._images.names if name is None else (name,)
            images = [image for image in map(self._images.get, names) if image is not None]
            if name is not None and not images:
                raise InputError(f"No image {name!r} has come from the renderer yet: wait for it.")
            return choose_image(images, options), lens_header(self._lens.get(LENS_IMAGE))

    def _serve(self) -> None:
        """Handle events until `close` is called; runs on the server's thread."""
        try:
            while self._serve_once():
                self._notify_if_due()
        finally:
            for client in tuple(self._clients):
                self._disconnect(client)
            self._selector.close()
            self._listener.close()
            self._wake.close()

    def _serve_once(self) -> bool:
        """Wait for the next event and handle it; return False if the server should end."""
        for key, _ in self._selector.select(self._notification_delay_s()):
            if key.fileobj is self._wake:
                return False
            if key.fileobj is self._listener:
                self._accept()
            elif key.data in self._clients:  # unless it was disconnected meanwhile
                self._read_from_client(key.data)
        return True

    def _accept(self) -> None:
        """Accept a client; if there are too many, disconnect the one silent for longest."""
        try:
            connection, _ = self._listener.accept()
        except OSError as error:  # the client has left already, or no file handle is free
            self._report_fault(f"A connection could not be accepted ({error.strerror}).")
            time.sleep(1 / NOTIFICATIONS_A_SECOND)  # the client may still be waiting; do not spin
            return
        if len(self._clients) >= MAX_CLIENTS:
            self._disconnect(min(self._clients, key=lambda client: client.last_received_s))
        connection.setblocking(False)
        client, self.left_s = _Client(connection), None
        self._clients.append(client)
        self._selector.register(connection, selectors.EVENT_READ, client)

    def _read_from_client(self, client: _Client) -> None:
        """Read what `client` has sent, up to the end of one packet."""
        try:
            chunk = client.socket.recv(min(client.stream.expected_bytes, _READ_BYTES))
        except BlockingIOError:
            return
        except OSError:  # the renderer may close its connection at any time
            chunk = b""
        if not chunk:
            self._disconnect(client)
            return
        client.last_received_s = time.monotonic()
        try:
            packet = client.stream.feed(chunk)
        except TevStreamError as error:
            self._count_dropped_packet(str(error))
            self._disconnect(client)
            return
        if packet is not None:
            self._handle_packet(packet, client)
        elif (
            sum(other_client.stream.buffered_bytes for other_client in self._clients)
            > MAX_BUFFERED_BYTES
        ):
            self._count_dropped_packet("the packets of all clients are too large together")
            self._disconnect(client)

    def _handle_packet(self, packet: bytearray, client: _Client) -> None:
        """Apply the message of a packet, or count the packet as dropped."""
        try:
            message = parse_message(packet)
            if isinstance(message, ReadFile):
                self._handle_file_request(message.name, client)
                return
            with self._lock:
                self._has_changed_images |= self._apply(message)
        except TevPacketError as error:
            self._count_dropped_packet(str(error))
        except MemoryError:
            self._count_dropped_packet("there is not enough memory for its image")

    def _apply(self, message: Message) -> bool:
        """Apply `message`; return whether the shown picture may have changed."""
        # Any new image replaces the requested file.
        if getattr(message, "name", "") == LENS_IMAGE:
            return self._lens.apply(message)
        if isinstance(message, CreateImage):
            self._file = None
        if isinstance(message, CloseImage) and message.name == str(self._file):
            self._file = None
            return True
        return self._images.apply(message)

    def _handle_file_request(self, name: str, client: _Client) -> None:
        """Show a requested file if the client could read it; else count a refusal."""
        try:
            path = check_requested_file(name, is_from_this_machine(client.socket))
        except InputError as error:
            self.refused += 1
            self._report_fault(str(error))
            return
        with self._lock:
            self._file, self._has_changed_images = path, True

    def _count_dropped_packet(self, reason: str) -> None:
        """Count a dropped packet, and report why it was dropped."""
        self.dropped += 1
        self._report_fault(f"A packet was dropped: {reason}.")

    def _report_fault(self, fault: str) -> None:
        """Store a fault, to be reported with the next news."""
        self.fault = fault
        self._has_new_fault = True

    def _notification_delay_s(self) -> float | None:
        """Return the seconds until a delayed notification is due; None if there is none."""
        if not (self._has_changed_images or self._has_new_fault):
            return None
        return max(0.0, self._last_notified_s + 1 / NOTIFICATIONS_A_SECOND - time.monotonic())

    def _notify_if_due(self) -> None:
        """Raise `version` and call `on_news`, if something is new and enough time has passed."""
        if self._notification_delay_s() != 0.0:
            return
        self.version += self._has_changed_images
        self._has_changed_images = self._has_new_fault = False
        self._last_notified_s = time.monotonic()
        if self._on_news is not None:
            self._on_news()

    def _disconnect(self, client: _Client) -> None:
        """Close the connection of a client and forget it."""
        self._clients.remove(client)
        self._selector.unregister(client.socket)
        client.socket.close()
        if not self._clients:
            self.left_s, self._has_new_fault = time.time(), True

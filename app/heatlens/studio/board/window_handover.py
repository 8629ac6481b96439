"""Let a running window open files that are named on a later command line.

The window listens on a port of this machine. It writes the port, a secret and its process into a
file that only the user can read, in the runtime folder of the system; whoever can read that file
could open files as the same user anyway. Both ends prove that they know the secret before anything
else is read.
Windows on different displays, or with other preferences, are independent.
"""

import hashlib
import json
import os
import secrets
import socket
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from contextlib import closing, contextmanager, suppress
from multiprocessing import ProcessError
from multiprocessing.connection import Connection, answer_challenge, deliver_challenge
from pathlib import Path
from threading import BoundedSemaphore, Thread, Timer
from typing import NamedTuple

from heatlens.core.base.errors import InputError
from heatlens.core.base.paths import (
    is_of_user_alone,
    preferences_dir,
    read_file_and_status,
    runtime_dir,
)
from heatlens.core.base.processes import is_running
from heatlens.media.files.atomic_file import FOR_THE_USER, write_atomically

_HOST = "127.0.0.1"
# Time limit of a whole request. A thread answers while the window draws, but not while a graphics
# driver that holds Python's lock builds a program, which takes seconds on a busy machine.
_PATIENCE_S = 30.0
_QUIET_S = 1.5  # of waiting for the window, before the user is told
_CLIENTS_MOST = 64  # requests at the same time
_REQUEST_MOST = 1 << 20  # bytes, enough for a thousand long names
_NAMES_MOST = 1000
_ANSWER = b"opened"
# Errors from a wrong secret, a closed connection or an unknown message; the standard library
# asserts the form of a challenge.
_REFUSALS = (OSError, EOFError, ValueError, AssertionError, ProcessError)


def handover_path() -> Path:
    """Return the file in which a window on this display publishes its port."""
    display = [os.environ.get(name, "") for name in ("WAYLAND_DISPLAY", "DISPLAY")]
    identity = json.dumps([*display, str(preferences_dir().absolute()), socket.gethostname()])
    return runtime_dir() / f"window-{hashlib.sha256(identity.encode()).hexdigest()[:16]}.json"


def hand_over(names: Sequence[str], tell_waiting: Callable[[], None] = lambda: None) -> bool:
    """Have the running window open the absolute paths `names`; return False if none answers.

    A window that is alive but busy is waited for, and `tell_waiting` is called then, on a thread.
    """
    with suppress(*_REFUSALS), _calling_later(tell_waiting, _QUIET_S):
        door = _read_handover(handover_path())
        with _limit_time(socket.create_connection((_HOST, door.port), _PATIENCE_S)) as connection:
            answer_challenge(connection, door.secret)
            deliver_challenge(connection, door.secret)
            connection.send_bytes(b"\0".join(map(os.fsencode, names)))
            return connection.recv_bytes(len(_ANSWER)) == _ANSWER
    return False


class _Door(NamedTuple):
    """Where a window listens: its port, the secret that it asks for, and its process."""

    port: int
    secret: bytes
    process: int


def _read_handover(path: Path) -> _Door:
    """Return where the window listens. Raises OSError or ValueError if this user has none."""
    text, status = read_file_and_status(path)
    record = json.loads(text) if is_of_user_alone(status) else None
    if not isinstance(record, dict) or not isinstance(record.get("port"), int):
        raise ValueError("a window would have written something else")
    process = record.get("process", os.getpid())  # earlier versions do not tell it
    if not isinstance(process, int) or not is_running(process):
        raise ValueError("the window has ended without removing its file")
    return _Door(record["port"], str(record.get("secret")).encode(), process)


# The whole request has one deadline. With a limit for each read, a client could keep the connection
# open by sending a byte each half second. Both ends prove that they know the secret before anything
# is parsed, by the challenge of multiprocessing.connection: otherwise, a line of brackets could end
# the thread that listens.
@contextmanager
def _limit_time(client_socket: socket.socket) -> Iterator[Connection]:
    """Yield a connection that closes unless the other end finishes in a limited time."""
    client_socket.settimeout(None)  # the limit of a single step would not limit the whole
    with (
        _calling_later(lambda: _shut_down(client_socket), _PATIENCE_S),
        client_socket,
        closing(Connection(client_socket.dup().detach())) as connection,
    ):
        yield connection


@contextmanager
def _calling_later(function: Callable[[], None], after_s: float) -> Iterator[None]:
    """Call a function on a thread unless the block ends earlier."""
    timer = Timer(after_s, function)
    timer.daemon = True
    timer.start()
    try:
        yield
    finally:
        timer.cancel()


def _shut_down(open_socket: socket.socket) -> None:
    """Wake the threads that wait for a socket."""
    with suppress(OSError):  # the other end has hung up
        open_socket.shutdown(socket.SHUT_RDWR)


class WindowHandover:
    """Listens for names while it is open; `pop_names` returns those that have arrived."""

    def __init__(self, wake: Callable[[], None], path: Path | None = None) -> None:
        """Begin to listen. `wake` is called on a thread when names have come.

        If listening or writing the file fails, no names will come, and the window works without.
        """
        self._wake = wake
        self._path = path or handover_path()
        self._names: deque[list[str]] = deque()
        self._secret = secrets.token_hex(32)
        self._clients = BoundedSemaphore(_CLIENTS_MOST)
        self._socket: socket.socket | None = None
        self._earlier_door: _Door | None = None  # of the window that listened before
        with suppress(OSError, InputError):
            self._start_listening()

    def _start_listening(self) -> None:
        """Listen on a free port, and write the port and the secret to the file."""
        self._path.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
        self._socket = listening_socket = socket.create_server((_HOST, 0), backlog=_CLIENTS_MOST)
        with suppress(OSError, ValueError):
            self._earlier_door = _read_handover(self._path)
        port = listening_socket.getsockname()[1]
        self._write_handover(_Door(port, self._secret.encode(), os.getpid()))
        Thread(target=self._accept_clients, args=(listening_socket,), daemon=True).start()

    def _write_handover(self, door: _Door) -> None:
        """Write to the file where a window listens."""
        record = door._asdict() | {"secret": door.secret.decode()}
        # Others may be able to write in the folder, so links there are not followed.
        write_atomically(self._path, json.dumps(record).encode(), FOR_THE_USER, follows_links=False)

    def pop_names(self) -> list[str]:
        """Return the names of the oldest waiting request and remove it; [] if there is none."""
        return self._names.popleft() if self._names else []

    def close(self) -> None:
        """Stop listening, and give the file back to the window that listened before, if any.

        A file that belongs to a later window stays.
        """
        with suppress(OSError, ValueError, InputError):
            if _read_handover(self._path).secret == self._secret.encode():
                self._path.unlink()
                if self._earlier_door is not None:
                    self._write_handover(self._earlier_door)
        if self._socket is not None:
            _shut_down(self._socket)
            self._socket.close()

    def _accept_clients(self, listening_socket: socket.socket) -> None:
        """Serve each client on a thread of its own until the socket is closed."""
        while True:
            self._clients.acquire()
            try:
                client_socket, _ = listening_socket.accept()
            except OSError:  # the socket was closed
                return
            Thread(target=self._serve_client, args=(client_socket,), daemon=True).start()

    def _serve_client(self, client_socket: socket.socket) -> None:
        """Receive the names of one client that knows the secret."""
        secret = self._secret.encode()
        try:
            with suppress(*_REFUSALS), _limit_time(client_socket) as connection:
                deliver_challenge(connection, secret)
                answer_challenge(connection, secret)
                names = connection.recv_bytes(_REQUEST_MOST).split(b"\0")
                if all(names) and len(names) <= _NAMES_MOST:
                    self._names.append([os.fsdecode(name) for name in names])
                    self._wake()
                    connection.send_bytes(_ANSWER)
        finally:
            self._clients.release()

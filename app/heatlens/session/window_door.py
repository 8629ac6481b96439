"""Let a running window open files that are named on a later command line.

The window listens on a port of this machine. It writes the port and a secret into a file that only
the user can read, in the runtime folder of the system; whoever can read that file could open files
as the same user anyway. A request is one line of JSON with the secret and the names; the answer is
one line. Windows on different displays, or with other preferences, are independent.
"""

import hashlib
import hmac
import json
import os
import secrets
import socket
import stat
import threading
from collections import deque
from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

from heatlens.errors import InputError
from heatlens.files.atomic_file import FOR_THE_USER, write_whole
from heatlens.folders import preferences_dir, runtime_dir

_HOST = "127.0.0.1"
_PATIENCE_S = 2.0  # time limit for an answer, which a thread gives even while the window draws
_REQUEST_MOST = 1 << 20  # bytes: a thousand long names
_NAMES_MOST = 1000
_ANSWER = b"opened\n"


def door_path() -> Path:
    """Return the file in which a window on this display publishes its port."""
    display = [os.environ.get(name, "") for name in ("WAYLAND_DISPLAY", "DISPLAY")]
    told = json.dumps([*display, str(preferences_dir().absolute()), socket.gethostname()])
    return runtime_dir() / f"window-{hashlib.sha256(told.encode()).hexdigest()[:16]}.json"


def hand_over(names: Sequence[str]) -> bool:
    """Have the running window open the absolute paths `names`; return False if none answers."""
    found = _read_door(door_path())
    if found is None:
        return False
    port, secret = found
    request = json.dumps({"secret": secret, "open": list(names)}).encode() + b"\n"
    try:
        with socket.create_connection((_HOST, port), _PATIENCE_S) as line:
            line.sendall(request)
            return line.makefile("rb").readline(len(_ANSWER)) == _ANSWER
    except OSError:
        return False


def _read_door(path: Path) -> tuple[int, str] | None:
    """Return port and secret; None if no window of this user has written them."""
    try:
        with open(path, "rb") as file:
            if not _is_of_user_alone(os.fstat(file.fileno())):
                return None
            told = json.loads(file.read(_REQUEST_MOST))
        return int(told["port"]), str(told["secret"])
    except (OSError, ValueError, KeyError, TypeError):
        return None


def _is_of_user_alone(status: os.stat_result) -> bool:
    """Return True if only this user owns and can access a file; always True on Windows."""
    if not hasattr(os, "getuid"):
        return True
    others = status.st_mode & (stat.S_IRWXG | stat.S_IRWXO)
    return status.st_uid == os.getuid() and not others


class WindowDoor:
    """Listens for names while it is open; `take` returns those that have arrived."""

    def __init__(self, wake: Callable[[], None], path: Path | None = None) -> None:
        """Begin to listen. `wake` is called on a thread when names have come.

        If listening or writing the file fails, no names will come, and the window works without.
        """
        self._wake = wake
        self._path = path or door_path()
        self._names: deque[list[str]] = deque()
        self._secret = secrets.token_hex(32)
        self._socket: socket.socket | None = None
        with suppress(OSError, InputError):
            self._open()

    def _open(self) -> None:
        self._path.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
        self._socket = listening = socket.create_server((_HOST, 0))
        told = {"port": listening.getsockname()[1], "secret": self._secret}
        write_whole(self._path, json.dumps(told).encode(), FOR_THE_USER)
        threading.Thread(target=self._listen, args=(listening,), daemon=True).start()

    def take(self) -> list[str]:
        """Return the names of the oldest waiting request and remove it; [] if there is none."""
        return self._names.popleft() if self._names else []

    def close(self) -> None:
        """Stop listening and delete the file, unless it belongs to a later window."""
        found = _read_door(self._path)
        if found is not None and hmac.compare_digest(found[1], self._secret):
            with suppress(OSError):
                self._path.unlink()
        if self._socket is not None:
            with suppress(OSError):  # wake the thread that waits in `accept`
                self._socket.shutdown(socket.SHUT_RDWR)
            self._socket.close()

    def _listen(self, listening: socket.socket) -> None:
        while True:
            try:
                line, _ = listening.accept()
            except OSError:  # the socket was closed
                return
            with suppress(OSError, ValueError), line:
                line.settimeout(_PATIENCE_S)
                self._answer(line)

    def _answer(self, line: socket.socket) -> None:
        """Take one request; do not answer a wrong one. Raises ValueError for invalid JSON."""
        names = _names_in(json.loads(line.makefile("rb").readline(_REQUEST_MOST)), self._secret)
        if names:
            self._names.append(names)
            self._wake()
            line.sendall(_ANSWER)


def _names_in(request: Any, secret: str) -> list[str]:
    """Return the names of a request with the right secret; an empty list otherwise."""
    told = request.get("secret") if isinstance(request, dict) else None
    if not (isinstance(told, str) and hmac.compare_digest(told.encode(), secret.encode())):
        return []
    names = request.get("open")
    is_good = isinstance(names, list) and 0 < len(names) <= _NAMES_MOST
    return names if is_good and all(isinstance(n, str) and n for n in names) else []

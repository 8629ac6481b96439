"""Parse the address on which a stream is received, and open its listening socket."""

import socket

from heatlens.core.base.errors import InputError
from heatlens.core.base.outside_text import host_and_port

DEFAULT_HOST = "127.0.0.1"  # only this machine, because the protocol has no password
DEFAULT_PORT = 14158


def parse_address(text: str) -> tuple[str, int]:
    """Parse "[HOST:]PORT"; the default host is this machine.

    An IPv6 host stands in brackets. Port 0 takes a free one. Raises InputError for anything else.
    """
    words = text.strip()
    try:
        host, port = host_and_port(f":{words}" if words.isdigit() else words)
    except ValueError:
        host, port = "", None
    if port is None or (words.startswith(":") and not host):
        raise InputError(
            f"{text!r} is not an address to listen on: give PORT or HOST:PORT, such as "
            f"{DEFAULT_PORT} or 0.0.0.0:{DEFAULT_PORT}."
        )
    return host or DEFAULT_HOST, port


def listening_socket(host: str, port: int) -> socket.socket:
    """Return a socket that waits for clients at `host`:`port`. Raises InputError."""
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    try:
        listener = socket.create_server((host, port), family=family)
    except (OSError, UnicodeError) as error:
        reason = getattr(error, "strerror", None) or error
        raise InputError(
            f"Cannot listen on {host}:{port} ({reason}): give another port or the address of this "
            "machine; tev itself, or another heatlens, may be listening there already."
        ) from error
    listener.setblocking(False)
    return listener

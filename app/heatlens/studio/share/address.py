"""The address on which a session is shared, its links, and the requests that are meant for it.

Each link has a secret token: one allows turning the lens, the other only looking. The tokens are
kept in a file that only the user may read; a link therefore still works after the server is started
again.
"""

import hmac
import json
import secrets
import ssl
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path

from heatlens.core.base.errors import InputError
from heatlens.core.base.outside_text import host_and_port
from heatlens.core.base.paths import is_of_user_alone, read_file_and_status
from heatlens.media.files.atomic_file import FOR_THE_USER, write_atomically

DEFAULT_PORT = 8870
_OWN_HOST = "127.0.0.1"
_OWN_HOST_NAMES = ("127.0.0.1", "localhost", "[::1]")
_ALL_HOSTS = ("0.0.0.0", "::", "*")


@dataclass(frozen=True)
class Address:
    """The address of the server; `certificate` is a PEM file with certificate and key for TLS."""

    host: str = _OWN_HOST
    port: int = DEFAULT_PORT
    certificate: Path | None = None

    @property
    def scheme(self) -> str:
        """The scheme of its links: https with a certificate, else http."""
        return "http" if self.certificate is None else "https"

    def url(self, port: int, token: str = "") -> str:
        """Return the link for a token, on the port that the server listens on."""
        return f"{self.scheme}://{_bracketed(self.host)}:{port}/" + (f"{token}/" if token else "")

    def hosts(self, port: int) -> frozenset[str]:
        """Return the Host headers of requests that are meant for this server.

        Others are refused, because a foreign page could point its own host name at this address.
        """
        own_name = _bracketed(self.host).lower()
        names = {own_name, *(_OWN_HOST_NAMES if own_name in _OWN_HOST_NAMES else ())}
        default_port = 80 if self.certificate is None else 443
        return frozenset(f"{name}:{port}" for name in names) | (
            names if port == default_port else set()
        )

    def tls(self) -> ssl.SSLContext | None:
        """Return the context for TLS, None without a certificate. Raises InputError."""
        if self.certificate is None:
            return None
        context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
        try:
            context.load_cert_chain(self.certificate)
        except OSError as error:  # ssl.SSLError is one
            raise InputError(
                f"{self.certificate} cannot be used for TLS ({error.strerror or error}): it should "
                "be a PEM file with the certificate and its private key."
            ) from error
        return context


@dataclass(frozen=True)
class ShareOptions:
    """The options of the command line: where to share, and whether earlier links become invalid."""

    address: Address = Address()
    has_new_links: bool = False


def parse_share_address(text: str, certificate: Path | None = None) -> Address:
    """Parse "HOST", "HOST:PORT" or ":PORT"; "" is this machine. Raises InputError otherwise."""
    try:
        host, port = host_and_port(text)
    except ValueError as error:
        raise InputError(
            f"{text!r} is not an address to listen on: give HOST, HOST:PORT or :PORT, such as "
            f"192.168.1.20 or 192.168.1.20:{DEFAULT_PORT}."
        ) from error
    if host in _ALL_HOSTS:
        raise InputError(
            f"{text!r} stands for every network of this machine: name the one address that the "
            "tablet reaches, such as 192.168.1.20 (`hostname -I` shows them)."
        )
    return Address(host or _OWN_HOST, DEFAULT_PORT if port is None else port, certificate)


def _bracketed(host: str) -> str:
    return f"[{host}]" if ":" in host else host


_TOKEN_BYTES = 16
_TOKEN_LETTERS = len(secrets.token_urlsafe(_TOKEN_BYTES))


class Role(StrEnum):
    """The rights that a link gives: to control the session, or only to look."""

    HAND = "hand"  # turn the lens, play, set keys
    LOOK = "look"  # look only


@dataclass(frozen=True)
class Links:
    """The secret token in the link of each role."""

    hand: str
    look: str

    def role_of(self, token: str) -> Role | None:
        """Return the role of a token; None for a wrong one. Takes the same time for any token."""
        token_bytes = token.encode("utf-8", "surrogateescape")
        is_hand = hmac.compare_digest(token_bytes, self.hand.encode())
        is_look = hmac.compare_digest(token_bytes, self.look.encode())
        return Role.HAND if is_hand else Role.LOOK if is_look else None


def new_links() -> Links:
    """Return links with new tokens of 128 bits."""
    return Links(secrets.token_urlsafe(_TOKEN_BYTES), secrets.token_urlsafe(_TOKEN_BYTES))


def load_or_make_links(path: Path, is_new: bool = False) -> Links:
    """Return the links in the file at `path`, or new ones, which are written there.

    `is_new` ends the earlier links. Raises InputError if the file cannot be written.
    """
    links = None if is_new else _load_links(path)
    if links is None:
        links = new_links()
        path.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
        text = json.dumps({"hand": links.hand, "look": links.look})
        write_atomically(path, text.encode(), FOR_THE_USER, follows_links=False)
    return links


def _load_links(path: Path) -> Links | None:
    """Return the links in a file; None where it is missing, damaged or open to others."""
    try:
        text, status = read_file_and_status(path)
        tokens = json.loads(text)
        links = Links(tokens["hand"], tokens["look"])
    except (OSError, ValueError, TypeError, KeyError):
        return None
    is_valid = all(
        isinstance(token, str) and token.isascii() and len(token) == _TOKEN_LETTERS
        for token in (links.hand, links.look)
    )
    return links if is_of_user_alone(status) and is_valid and links.hand != links.look else None

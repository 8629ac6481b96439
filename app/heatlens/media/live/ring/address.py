"""Parse addresses for lens samples, and open sockets that listen there."""

import ipaddress
import socket
import struct
from dataclasses import dataclass
from enum import StrEnum

from heatlens.core.base.errors import InputError
from heatlens.core.base.outside_text import host_and_port

DEFAULT_HOST = "127.0.0.1"  # only this machine; a camera on the network must be named
OPENTRACKIO_PORT = 55555
OSC_PORT = 9000
_SOURCE_GROUPS = "239.135.1."  # multicast groups begin so, and end in a source number
_RECEIVE_BYTES = 1 << 20  # buffer for 1,000 datagrams a second while the program is busy


class Protocol(StrEnum):
    """The protocols of lens samples."""

    OPENTRACKIO = "opentrackio"
    OSC = "osc"

    @property
    def port(self) -> int:
        """The default port."""
        return {Protocol.OPENTRACKIO: OPENTRACKIO_PORT, Protocol.OSC: OSC_PORT}[self]

    @property
    def is_stream(self) -> bool:
        """True for a camera, which sends all the time; a controller sends only when it is moved."""
        return self is Protocol.OPENTRACKIO


@dataclass(frozen=True)
class RingAddress:
    """A protocol at an IPv4 host and a UDP port."""

    protocol: Protocol
    host: str
    port: int

    def __str__(self) -> str:
        return f"{self.protocol}://{self.host}:{self.port}"

    @property
    def is_multicast(self) -> bool:
        """True for a multicast group, which several listeners can share."""
        return ipaddress.ip_address(self.host).is_multicast

    @property
    def source_number(self) -> int:
        """The number of the source whose group this is, 239.135.1.NUMBER; 1 for other hosts."""
        return int(self.host.rpartition(".")[2]) if self.host.startswith(_SOURCE_GROUPS) else 1


def parse_ring_address(text: str) -> RingAddress:
    """Parse "opentrackio[://[HOST][:PORT]]", or osc; the default host is this machine.

    Raise InputError for any other text.
    """
    scheme, _, host_text = text.strip().partition("://")
    try:
        protocol = Protocol(scheme.lower())
        host, port = host_and_port(host_text)
        host = DEFAULT_HOST if host in ("", "localhost") else str(ipaddress.IPv4Address(host))
    except ValueError as error:
        raise _address_error(text) from error
    return RingAddress(protocol, host, protocol.port if port is None else port)


def _address_error(text: str, is_output: bool = False) -> InputError:
    """Return the error for a text that is no address; `is_output` leaves out the hint on OSC."""
    osc_note = "" if is_output else f", or osc://:{OSC_PORT} for a controller"
    return InputError(
        f"{text!r} is not an address for a lens: give opentrackio for this machine, or "
        f"opentrackio://HOST:PORT, such as opentrackio://239.135.1.1:{OPENTRACKIO_PORT} for source "
        f"1 of a network{osc_note}."
    )


def opentrackio_address(text: str) -> RingAddress:
    """Parse an address to send a lens to. Raise InputError for another protocol."""
    try:
        address = parse_ring_address(text)
    except InputError as error:
        raise _address_error(text, is_output=True) from error
    if address.protocol is not Protocol.OPENTRACKIO:
        raise InputError(
            f"{text}: a camera can only be sent as OpenTrackIO: write opentrackio or "
            "opentrackio://HOST:PORT."
        )
    return address


def listening_socket(address: RingAddress) -> socket.socket:
    """Return a socket that receives the datagrams sent to `address`.

    Several listeners can share a multicast group. Raise InputError if the address cannot be used.
    """
    listener = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    try:
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, _RECEIVE_BYTES)
        if address.is_multicast:
            listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        listener.bind((address.host, address.port))
        if address.is_multicast:
            group = struct.pack("!4sI", socket.inet_aton(address.host), socket.INADDR_ANY)
            listener.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, group)
    except OSError as error:
        listener.close()
        raise InputError(
            f"Cannot listen at {address} ({error.strerror or error}): another program may listen "
            "there already, or the host is not an address of this machine."
        ) from error
    listener.setblocking(False)
    return listener

"""Decide whether a file that a client asks to open may be read."""

import ipaddress
import socket
from pathlib import Path

from heatlens.core.base.errors import InputError
from heatlens.core.base.outside_text import printable
from heatlens.media.files.picture_formats import is_picture

_NAME_LETTERS_MOST = 200


def check_requested_file(name: str, is_local: bool) -> Path:
    """Return the path of a picture file that a client asks to open.

    Raises InputError if the client is on another machine, and so could not read the file itself, or
    if `name` is not the full path of an existing EXR or picture.
    """
    sentence_start = f"A program asked for the file {printable(name)[:_NAME_LETTERS_MOST]!r}"
    path = Path(name)
    if not is_local:
        raise InputError(f"{sentence_start}: files are opened only for programs on this machine.")
    if path.suffix.lower() != ".exr" and not is_picture(path):
        raise InputError(f"{sentence_start}: only EXR and other picture files are opened.")
    if not path.is_absolute():
        raise InputError(f"{sentence_start}: a file is opened only by its full path.")
    try:
        exists = path.is_file()  # a pipe or a device is not a picture
    except (OSError, ValueError):  # not a valid file name
        exists = False
    if not exists:
        raise InputError(f"{sentence_start}: there is no such file.")
    return path


def is_from_this_machine(connection: socket.socket) -> bool:
    """Return True if the other end of a connection is on this machine."""
    try:
        host = connection.getpeername()[0]
        return ipaddress.ip_address(host.partition("%")[0]).is_loopback
    except (OSError, ValueError, IndexError):  # it has disconnected, or has no internet address
        return False

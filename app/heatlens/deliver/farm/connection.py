"""Connect with the scheduler of a Dask cluster, once it is known which one answers."""

import logging
import re
import socket
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from types import ModuleType
from typing import Any
from urllib.parse import urlsplit

from heatlens.core.base.errors import InputError
from heatlens.core.base.extras import import_extra
from heatlens.core.base.outside_text import printable
from heatlens.deliver.farm.dask_types import Client
from heatlens.deliver.farm.data_only import take_only_data

PATIENCE_S = 10  # time limit for an answer of the scheduler
_ADDRESS = re.compile(r"(tcp|tls|wss?)://(\[[\da-f:.]+\]|[^\s/:]+):\d{1,5}")
NO_ANSWER = (OSError, ValueError, TimeoutError)  # raised if there is no answer
_LOSSES = ("FutureCancelledError", "CancelledError", "CommClosedError")  # the scheduler has died


def library() -> ModuleType:
    """Import Dask. Raises InputError that says what to install."""
    dask = import_extra("distributed")
    # They would log every lost connection, and every message that is refused.
    for name in ("distributed", "distributed.client", "distributed.protocol.core"):
        logging.getLogger(name).setLevel(logging.CRITICAL + 1)
    return dask


@dataclass(frozen=True)
class Met:
    """A scheduler that answers, and the address of this machine in the network to it.

    name  what the scheduler calls itself, which is new each time it is started
    """

    scheduler: str
    name: str
    own_host: str

    @property
    def text(self) -> str:
        """Return what identifies it, for `only`."""
        return f"{self.name}@{self.own_host}"


def met(address: str) -> Met:
    """Return which scheduler answers, and read only data from it. Raises as `who_answers` does."""
    take_only_data(library())
    return who_answers(address)


def who_answers(address: str) -> Met:
    """Return which scheduler answers. Raises InputError if none does, or one of another Dask."""
    import asyncio  # here, because every export imports this module

    checked_address(address)
    distributed = library()
    try:
        answers = asyncio.run(asyncio.wait_for(_asked(distributed, address), PATIENCE_S))
        name, version = str(answers[0]["id"]), str(answers[1]["packages"]["distributed"])
        own = own_host(address)
    except (*NO_ANSWER, TypeError, KeyError) as error:
        raise no_answer(address) from error
    check_version(address, version)
    return Met(address, name, own)


async def _asked(distributed: ModuleType, address: str) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return what a scheduler calls itself, and its versions."""
    secured = distributed.Security().get_connection_args("client")
    async with distributed.rpc(address, connection_args=secured) as scheduler:
        return await scheduler.identity(), await scheduler.versions()


# Dask's versions do not speak to each other (2025.1 and 2026.8 were tried), and what they say then
# is no sentence for a user. So the versions are compared before the first task is sent.
def check_version(address: str, version: str) -> None:
    """Raise InputError if the scheduler has another version of Dask than this machine."""
    here = library().__version__
    if version != here:
        raise InputError(
            f"The scheduler at {address} has Dask {printable(version)[:40]}, but this machine has "
            f"{here}: install distributed=={here} on all machines."
        )


def own_host(address: str) -> str:
    """Return the address by which this machine reaches the host in `address`. Raises OSError."""
    parts = urlsplit(address)
    addresses = socket.getaddrinfo(parts.hostname, parts.port, type=socket.SOCK_DGRAM)
    family, kind, protocol, _, where = addresses[0]
    with socket.socket(family, kind, protocol) as asked:
        asked.connect(where)  # a datagram socket sends nothing for this
        return str(asked.getsockname()[0])


def check_own(host: str) -> None:
    """Raise InputError if this machine cannot listen on the address `host`."""
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    try:
        with socket.socket(family, socket.SOCK_STREAM) as tried:
            tried.bind((host, 0))
    except (OSError, UnicodeError) as error:
        raise InputError(
            f"--host {host} is no address of this machine to listen on ({error}): name one that "
            "the scheduler and the exports reach, such as 192.168.1.20, or leave it out."
        ) from error


def only(agreed: str | None) -> Callable[[Met], None]:
    """Return a check that takes the scheduler with this text alone, and for None any."""

    def check(answering: Met) -> None:
        if agreed is not None and answering.text != agreed:
            raise InputError(
                f"The scheduler at {answering.scheduler} was started again, is another, or is "
                "reached through another network than before: export again to use it."
            )

    return check


_ANY = only(None)


@contextmanager
def connected(address: str, check: Callable[[Met], None] = _ANY) -> Iterator[Client]:
    """Yield a client of the scheduler at `address`. Raises InputError if it does not answer.

    `check` may raise an InputError for a scheduler that it does not know.
    """
    check(met(address))
    try:
        client = library().Client(address, timeout=PATIENCE_S, set_as_default=False)
    except NO_ANSWER as error:
        raise no_answer(address) from error
    try:
        yield client
    finally:
        client.close(timeout=PATIENCE_S)


def checked_address(text: str) -> str:
    """Return the address in a text. Raises InputError if it is none."""
    address = text.strip()
    if not _ADDRESS.fullmatch(address):
        raise no_answer(repr(address))
    return address


def no_answer(address: str) -> InputError:
    """Return the error for a scheduler that does not answer."""
    return InputError(
        f"No Dask scheduler answers at {address}. Start one with `dask scheduler`, and name its "
        "address, such as tcp://192.168.1.20:8786."
    )


def not_data(address: str) -> InputError:
    """Return the error for messages of Dask that hold more than data."""
    return InputError(
        f"The scheduler at {address} has sent what is no data, which was refused because it could "
        "run programs here. Find out what runs there before you use it again."
    )


def is_loss(error: Exception) -> bool:
    """Return True for the errors of Dask after the loss of its scheduler."""
    return isinstance(error, NO_ANSWER) or type(error).__name__ in _LOSSES

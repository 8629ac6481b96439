"""Connect to the scheduler of a Dask cluster, after checking which scheduler answers."""

import logging
import re
import socket
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
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
# The scheduler has died.
_LOSS_ERRORS = ("FutureCancelledError", "CancelledError", "CommClosedError")


def library() -> ModuleType:
    """Import Dask. Raises InputError that says what to install."""
    dask = import_extra("distributed")
    # They would log every lost connection, and every message that is refused.
    for name in ("distributed", "distributed.client", "distributed.protocol.core"):
        logging.getLogger(name).setLevel(logging.CRITICAL + 1)
    return dask


@dataclass(frozen=True)
class SchedulerIdentity:
    """A scheduler that answers, and the address of this machine in the network to it.

    name  ID of the scheduler, which is new each time it is started
    """

    scheduler: str
    name: str
    own_host: str

    @property
    def text(self) -> str:
        """The scheduler's ID and own address as one text, for `check_for_scheduler`."""
        return f"{self.name}@{self.own_host}"


def identify_scheduler_safely(address: str) -> SchedulerIdentity:
    """Return which scheduler answers, after Dask was limited to reading data.

    Raises InputError as `identify_scheduler` does.
    """
    take_only_data(library())
    return identify_scheduler(address)


def identify_scheduler(address: str) -> SchedulerIdentity:
    """Return which scheduler answers. Raises InputError if none does, or one of another Dask."""
    import asyncio  # here, because every export imports this module

    parse_address(address)
    distributed = library()
    try:
        answers = asyncio.run(asyncio.wait_for(_ask_identity(distributed, address), PATIENCE_S))
        name, version = str(answers[0]["id"]), str(answers[1]["packages"]["distributed"])
        own_address = own_host(address)
    except (*NO_ANSWER, TypeError, KeyError) as error:
        raise no_answer_error(address) from error
    check_version(address, version)
    return SchedulerIdentity(scheduler=address, name=name, own_host=own_address)


async def _ask_identity(
    distributed: ModuleType, address: str
) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return the identity of a scheduler, and the versions of its packages."""
    secured = distributed.Security().get_connection_args("client")
    async with distributed.rpc(address, connection_args=secured) as scheduler:
        return await scheduler.identity(), await scheduler.versions()


# Different versions of Dask cannot work together (2025.1 and 2026.8 were tried), and their error
# messages do not help a user. Therefore the versions are compared before the first task is sent.
def check_version(address: str, version: str) -> None:
    """Raise InputError if the scheduler has another version of Dask than this machine."""
    own_version = library().__version__
    if version != own_version:
        raise InputError(
            f"The scheduler at {address} has Dask {printable(version)[:40]}, but this machine has "
            f"{own_version}: install distributed=={own_version} on all machines."
        )


def own_host(address: str) -> str:
    """Return the address by which this machine reaches the host in `address`. Raises OSError."""
    parts = urlsplit(address)
    addresses = socket.getaddrinfo(parts.hostname, parts.port, type=socket.SOCK_DGRAM)
    family, kind, protocol, _, socket_address = addresses[0]
    with socket.socket(family, kind, protocol) as datagrams:
        datagrams.connect(socket_address)  # a datagram socket sends nothing for this
        return str(datagrams.getsockname()[0])


def check_own_address(host: str) -> None:
    """Raise InputError if this machine cannot listen on the address `host`."""
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    try:
        with socket.socket(family, socket.SOCK_STREAM) as listener:
            listener.bind((host, 0))
    except (OSError, UnicodeError) as error:
        raise InputError(
            f"--host {host} is no address of this machine to listen on ({error}): name one that "
            "the scheduler and the exports reach, such as 192.168.1.20, or leave it out."
        ) from error


def check_for_scheduler(identity_text: str | None) -> Callable[[SchedulerIdentity], None]:
    """Return a check that accepts only the scheduler with this identity; any one for None."""

    def check(answering: SchedulerIdentity) -> None:
        if identity_text is not None and answering.text != identity_text:
            raise InputError(
                f"The scheduler at {answering.scheduler} was started again, is another, or is "
                "reached through another network than before: export again to use it."
            )

    return check


_ANY_SCHEDULER = check_for_scheduler(identity_text=None)


@contextmanager
def connected(
    address: str, check: Callable[[SchedulerIdentity], None] = _ANY_SCHEDULER
) -> Iterator[Client]:
    """Yield a client of the scheduler at `address`. Raises InputError if it does not answer.

    `check` may raise an InputError for an unknown scheduler.
    """
    check(identify_scheduler_safely(address))
    try:
        client = library().Client(address, timeout=PATIENCE_S, set_as_default=False)
    except NO_ANSWER as error:
        raise no_answer_error(address) from error
    client._reconnect = partial(_cancel_futures, client)
    try:
        yield client
    finally:
        client.close(timeout=PATIENCE_S)


# By default Dask connects again after a loss. But its futures are lost with the scheduler, and a
# client that is closed while it connects leaves its socket open.
async def _cancel_futures(client: Any) -> None:
    """Cancel all futures of a client that has lost its scheduler, and leave it disconnected."""
    client.scheduler_comm = None
    for state in client.futures.values():
        state.cancel(reason="scheduler-connection-lost", msg="The scheduler has gone.")
    client.futures.clear()


def parse_address(text: str) -> str:
    """Return the address in a text, without spaces around it. Raises InputError for other texts."""
    address = text.strip()
    if not _ADDRESS.fullmatch(address):
        raise no_answer_error(repr(address))
    return address


def no_answer_error(address: str) -> InputError:
    """Return the error for a scheduler that does not answer."""
    return InputError(
        f"No Dask scheduler answers at {address}. Start one with `dask scheduler`, and name its "
        "address, such as tcp://192.168.1.20:8786."
    )


def not_data_error(address: str) -> InputError:
    """Return the error for messages of Dask that hold more than data."""
    return InputError(
        f"The scheduler at {address} has sent what is no data, which was refused because it could "
        "run programs here. Find out what runs there before you use it again."
    )


def is_loss(error: Exception) -> bool:
    """Return True for the errors of Dask after the loss of its scheduler."""
    return isinstance(error, NO_ANSWER) or type(error).__name__ in _LOSS_ERRORS

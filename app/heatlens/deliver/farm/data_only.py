"""Read messages of a cluster as data only; no other machine can then run code in this process.

Dask unpickles results, the types of results, errors, warnings and every message that is marked as a
pickle, and a pickle can call any function. All of them pass through one function of Dask. It is
replaced here by a reader that accepts no function, and no class but futures and Python's own
errors.
"""

import builtins
import io
import pickle
from collections.abc import Iterable
from functools import cache
from types import ModuleType
from typing import Any

# A future holds the name of a task; results that are bytes name their type.
_DATA = (("distributed.client", "Future"), ("builtins", "bytes"))


class NotDataError(TypeError):
    """A machine of the cluster has sent something other than data."""


# The workers of heatlens answer with a line of JSON and bytes behind it (`answers.py`). Therefore
# only the classes are needed here that Dask itself wraps around an answer.
class _DataReader(pickle.Unpickler):
    """Unpickles data, and refuses everything that could run code."""

    def find_class(self, module: str, name: str) -> object:
        """Return a class that only holds data. Raises NotDataError for everything else."""
        if (module, name) in _DATA:
            return super().find_class(module, name)
        builtin = getattr(builtins, name, None) if module == "builtins" else None
        if isinstance(builtin, type) and issubclass(builtin, Exception):
            return builtin
        raise NotDataError(f"{module}.{name} is not data")


def _load_data(data: bytes | memoryview, *, buffers: Iterable[bytes | memoryview] = ()) -> object:
    return _DataReader(io.BytesIO(data), buffers=buffers).load()


@cache  # once for each process
def take_only_data(distributed: ModuleType) -> None:
    """Make the Dask clients of this process accept only data.

    By default they also obey events by which any worker can have them unpickle, print or warn.
    Their handlers of such events are removed.
    """
    distributed.protocol.pickle.loads = _load_data
    distributed.client.loads = _load_data
    distributed.Client._default_event_handlers = {}
    _close_after_refusals(distributed.comm.tcp.TCP)


def _close_after_refusals(connection: Any) -> None:
    """Make connections of this class close after a message that is not data.

    Dask itself closes a connection for every other error of reading, but not for an unreadable
    message.
    """
    read = connection.read

    async def read_data(self: Any, *words: object, **named: object) -> object:
        try:
            return await read(self, *words, **named)
        except NotDataError:
            self.abort()
            raise

    connection.read = read_data

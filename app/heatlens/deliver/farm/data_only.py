"""Read what a cluster sends as data, so that none of its machines runs code in this process.

Dask unpickles results, the types of results, errors, warnings and every message that says it is a
pickle, and a pickle can call any function. All of them pass through one function of Dask, which is
replaced here by a reader that finds no function, and no class but futures and Python's own errors.
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


# The workers of heatlens answer with a line of JSON and bytes behind it (`answers.py`), so that
# nothing needs to be found here but what Dask itself wraps around an answer.
class _DataReader(pickle.Unpickler):
    def find_class(self, module: str, name: str) -> object:
        """Return a class that only holds data. Raises NotDataError for everything else."""
        if (module, name) in _DATA:
            return super().find_class(module, name)
        builtin = getattr(builtins, name, None) if module == "builtins" else None
        if isinstance(builtin, type) and issubclass(builtin, Exception):
            return builtin
        raise NotDataError(f"{module}.{name} is not data")


def _read(data: bytes | memoryview, *, buffers: Iterable[bytes | memoryview] = ()) -> object:
    return _DataReader(io.BytesIO(data), buffers=buffers).load()


@cache  # once for each process
def take_only_data(distributed: ModuleType) -> None:
    """Let the clients of Dask in this process take only data.

    They would also unpickle, print and warn what any worker tells them to; now they do not listen.
    """
    distributed.protocol.pickle.loads = _read
    distributed.client.loads = _read
    distributed.Client._default_event_handlers = {}
    _close_after_refusals(distributed.comm.tcp.TCP)


def _close_after_refusals(connection: Any) -> None:
    """Let this class of connections close one that has sent something other than data.

    Dask closes a connection for every error of reading but that of an unreadable message.
    """
    read = connection.read

    async def read_data(self: Any, *words: object, **named: object) -> object:
        try:
            return await read(self, *words, **named)
        except NotDataError:
            self.abort()
            raise

    connection.read = read_data

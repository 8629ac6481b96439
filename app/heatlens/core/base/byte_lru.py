"""Keep the values that were used last, within a limit of bytes."""

from collections import OrderedDict
from collections.abc import Callable, Hashable
from typing import Generic, TypeVar

K = TypeVar("K", bound=Hashable)
V = TypeVar("V")


class ByteLru(Generic[K, V]):
    """Values by key; the one that was used longest ago is dropped first.

    Not thread-safe: the caller holds a lock, because it mostly has more to guard than this.
    """

    def __init__(
        self, limit_bytes: int, bytes_of: Callable[[V], int], keeps_newest: bool = False
    ) -> None:
        """Keep up to `limit_bytes`; a larger value only if it is put last and `keeps_newest`."""
        self._limit_bytes = limit_bytes
        self._bytes_of = bytes_of
        self._least = 1 if keeps_newest else 0
        self._held: OrderedDict[K, tuple[V, int]] = OrderedDict()  # latest used last
        self.bytes_in_use = 0

    def get(self, key: K) -> V | None:
        """Return the value and mark it as used; None if it is not kept."""
        if key not in self._held:
            return None
        self._held.move_to_end(key)
        return self._held[key][0]

    def put(self, key: K, value: V) -> None:
        """Keep a value in place of the one that had its key, and drop others to make room."""
        self._drop(key)
        size = self._bytes_of(value)
        # Without this check a value that does not fit would push out all others before it goes.
        if size > self._limit_bytes and not self._least:
            return
        self._held[key] = value, size
        self.bytes_in_use += size
        while len(self._held) > self._least and self.bytes_in_use > self._limit_bytes:
            self._drop(next(iter(self._held)))

    def _drop(self, key: K) -> None:
        _, size = self._held.pop(key, (None, 0))
        self.bytes_in_use -= size

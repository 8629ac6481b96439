"""Keep the values that were used last, within a limit of bytes."""

import threading
from collections import OrderedDict
from collections.abc import Callable, Hashable
from typing import Generic, TypeVar

K = TypeVar("K", bound=Hashable)
V = TypeVar("V")


class ByteLru(Generic[K, V]):
    """Values by key, for any thread; the one that was used longest ago is dropped first."""

    def __init__(
        self, limit_bytes: int, bytes_of: Callable[[V], int], keeps_newest: bool = False
    ) -> None:
        """Keep values of up to `limit_bytes` in all; `bytes_of` returns the size of a value.

        With `keeps_newest`, the value that was put last is kept even if it is larger.
        """
        self.limit_bytes = limit_bytes
        self._bytes_of = bytes_of
        self._count_least = 1 if keeps_newest else 0
        self._lock = threading.Lock()
        self._entries: OrderedDict[K, tuple[V, int]] = OrderedDict()  # latest used last
        self._bytes = 0

    @property
    def bytes_in_use(self) -> int:
        """The bytes of all values."""
        return self._bytes

    def keys(self) -> frozenset[K]:
        """Return the keys of all values."""
        with self._lock:
            return frozenset(self._entries)

    def get(self, key: K) -> V | None:
        """Return the value and mark it as used; None if it is not kept."""
        with self._lock:
            if key not in self._entries:
                return None
            self._entries.move_to_end(key)
            return self._entries[key][0]

    def put(self, key: K, value: V) -> None:
        """Keep `value` in place of that of `key`, and drop old values to fit the limit."""
        size = self._bytes_of(value)
        with self._lock:
            self._drop(key)
            # Without this check a value that does not fit would push out all others before it goes.
            if size <= self.limit_bytes or self._count_least:
                self._entries[key] = value, size
                self._bytes += size
                self._trim()

    def resize(self, limit_bytes: int) -> None:
        """Set another limit, and drop values beyond it at once."""
        with self._lock:
            self.limit_bytes = limit_bytes
            self._trim()

    def clear(self) -> None:
        """Drop all values."""
        with self._lock:
            self._entries.clear()
            self._bytes = 0

    def _trim(self) -> None:
        """Drop the values that were used longest ago until the rest fits the limit."""
        while len(self._entries) > self._count_least and self._bytes > self.limit_bytes:
            self._drop(next(iter(self._entries)))

    def _drop(self, key: K) -> None:
        """Remove the value of `key`, if there is one."""
        _, size = self._entries.pop(key, (None, 0))
        self._bytes -= size

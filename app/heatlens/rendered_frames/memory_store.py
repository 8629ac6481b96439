"""Keep pictures in memory within a limit; the least recently used are dropped first.

`LimitedStore` is the base of stores that keep pictures within a size limit.
"""

import threading
from collections import OrderedDict

from heatlens.base.free_memory import free_memory_bytes
from heatlens.rendered_frames.kept_picture import KeptPicture

_FREE_SHARE = 4  # the default limit is a quarter of the free memory
_UNKNOWN_FREE = 4 << 30  # bytes, if the free memory is unknown


class LimitedStore:
    """Counts the bytes of stored pictures by key; may be called from any thread."""

    def __init__(self, limit_bytes: int) -> None:
        self._lock = threading.Lock()
        self._sizes: dict[str, int] = {}  # bytes by key; guarded by the lock
        self.limit_bytes = limit_bytes  # the largest sum that the store keeps

    @property
    def bytes_in_use(self) -> int:
        """The bytes of all stored pictures."""
        with self._lock:
            return sum(self._sizes.values())

    def keys(self) -> frozenset[str]:
        """Return the keys of all stored pictures, without waiting for a disk."""
        with self._lock:
            return frozenset(self._sizes)


class MemoryStore(LimitedStore):
    """Holds pictures by key. Every method may be called from any thread."""

    def __init__(self, limit_bytes: int) -> None:
        super().__init__(limit_bytes)
        self._held: OrderedDict[str, KeptPicture] = OrderedDict()

    def resize(self, limit_bytes: int) -> None:
        """Set another limit, and drop pictures beyond it at once."""
        with self._lock:
            self.limit_bytes = limit_bytes
            self._trim(limit_bytes)

    def get(self, key: str) -> KeptPicture | None:
        """Return the picture and mark it as used; None if it is not in memory."""
        with self._lock:
            if key in self._held:
                self._held.move_to_end(key)
            return self._held.get(key)

    def put(self, key: str, picture: KeptPicture) -> None:
        """Keep a picture, unless it is larger than the limit."""
        with self._lock:
            self._drop(key)
            size = picture.pixels.nbytes
            if size <= self.limit_bytes:
                self._trim(self.limit_bytes - size)
                self._held[key], self._sizes[key] = picture, size

    def clear(self) -> None:
        """Drop all pictures."""
        with self._lock:
            self._held.clear()
            self._sizes.clear()

    def _trim(self, most: int) -> None:
        total = sum(self._sizes.values())
        while total > most:
            oldest = next(iter(self._held))
            total -= self._sizes[oldest]
            self._drop(oldest)

    def _drop(self, key: str) -> None:
        self._held.pop(key, None)
        self._sizes.pop(key, None)


def default_memory_bytes() -> int:
    """Return a quarter of the currently free memory in bytes."""
    free = free_memory_bytes()
    return (_UNKNOWN_FREE if free is None else free) // _FREE_SHARE

"""The base of stores that keep pictures within a size limit."""

import threading


class LimitedStore:
    """Counts the bytes of stored pictures by key; may be called from any thread."""

    def __init__(self, limit_bytes: int) -> None:
        self._lock = threading.Lock()
        self._sizes: dict[str, int] = {}  # bytes by key; guarded by the lock
        self._limit = limit_bytes

    @property
    def limit_bytes(self) -> int:
        """The largest sum of bytes that the store keeps."""
        return self._limit

    @property
    def bytes_in_use(self) -> int:
        """The bytes of all stored pictures."""
        with self._lock:
            return sum(self._sizes.values())

    def keys(self) -> frozenset[str]:
        """Return the keys of all stored pictures, without waiting for a disk."""
        with self._lock:
            return frozenset(self._sizes)

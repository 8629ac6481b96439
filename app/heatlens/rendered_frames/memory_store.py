"""Keep pictures in memory within a limit; the least recently used are dropped first."""

import threading
from collections import OrderedDict

from heatlens.rendered_frames.kept_picture import KeptPicture

_FREE_SHARE = 4  # the default limit is a quarter of the free memory
_UNKNOWN_FREE = 4 << 30  # bytes, if the free memory is unknown


class MemoryStore:
    """Holds pictures by key. Every method may be called from any thread."""

    def __init__(self, limit_bytes: int) -> None:
        self._lock = threading.Lock()
        self._held: OrderedDict[str, KeptPicture] = OrderedDict()
        self._bytes = 0
        self._limit = limit_bytes

    @property
    def limit_bytes(self) -> int:
        """Return the bound."""
        return self._limit

    @property
    def bytes_in_use(self) -> int:
        """Return the bytes of all pictures, never more than the limit."""
        with self._lock:
            return self._bytes

    def resize(self, limit_bytes: int) -> None:
        """Set another limit, and drop pictures beyond it at once."""
        with self._lock:
            self._limit = limit_bytes
            self._trim(limit_bytes)

    def keys(self) -> frozenset[str]:
        """Return the keys of all pictures in memory."""
        with self._lock:
            return frozenset(self._held)

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
            if picture.nbytes <= self._limit:
                self._trim(self._limit - picture.nbytes)
                self._held[key] = picture
                self._bytes += picture.nbytes

    def clear(self) -> None:
        """Drop all pictures."""
        with self._lock:
            self._held.clear()
            self._bytes = 0

    def _trim(self, most: int) -> None:
        while self._bytes > most:
            self._drop(next(iter(self._held)))

    def _drop(self, key: str) -> None:
        gone = self._held.pop(key, None)
        self._bytes -= 0 if gone is None else gone.nbytes


def default_memory_bytes() -> int:
    """Return a quarter of the currently free memory in bytes."""
    return _free_bytes() // _FREE_SHARE


def _free_bytes() -> int:
    try:
        with open("/proc/meminfo", encoding="ascii") as lines:
            facts = dict(line.split(":", 1) for line in lines)
        return int(facts["MemAvailable"].split()[0]) * 1024
    except (OSError, KeyError, ValueError):  # not Linux, or an old version of it
        return _UNKNOWN_FREE

"""Decide which user has the lens: the latest touch wins once the other user rests."""

import time
from collections.abc import Callable
from threading import Lock

REST_S = 0.5  # time that a user keeps the lens after the last touch
WINDOW = "the window"


class Hands:
    """Decides which of several users may turn the lens; any thread may ask."""

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._lock = Lock()
        self._holder = ""
        self._touched_at = 0.0

    def take(self, hand: str) -> bool:
        """Return True if `hand` may turn the lens now, and has it then."""
        with self._lock:
            now = self._clock()
            if self._holder not in ("", hand) and now - self._touched_at < REST_S:
                return False
            self._holder, self._touched_at = hand, now
            return True

    @property
    def holder(self) -> str:
        """The user who has the lens; "" once it is free."""
        with self._lock:
            is_held = self._clock() - self._touched_at < REST_S
            return self._holder if is_held else ""

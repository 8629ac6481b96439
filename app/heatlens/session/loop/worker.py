"""The base of parts of the session that are polled once in each frame of the window."""


class Worker:
    """The base of every worker, which has nothing to do.

    A session holds its workers in one tuple, so that none is polled but forgotten when the loop
    sleeps.
    """

    def poll(self) -> None:
        """Take over arrived results, and continue. Raise HeatlensError if that fails."""

    def seconds_until_needed(self) -> float | None:
        """Return how many seconds the loop may sleep; None to sleep until an event."""
        return None

    def close(self) -> None:
        """Finish writing, and end all threads."""

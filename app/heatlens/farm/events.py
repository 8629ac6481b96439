"""Read what a `heatlens export --progress json` prints while it works."""

import json
import os
import subprocess
from threading import Thread
from typing import Any

_EVENTS = ("begin", "frame", "end", "failed")
_SAID_BYTES = 65536
Event = dict[str, Any]


def event_in(line: str | bytes) -> Event | None:
    """Return the event in a printed line; None for any other line, such as one of a driver."""
    try:
        told = json.loads(line)
    except (ValueError, RecursionError):
        return None
    return told if isinstance(told, dict) and told.get("event") in _EVENTS else None


class Said:
    """The last words of a process on stderr, read on a thread so that it never waits to print."""

    def __init__(self, process: "subprocess.Popen[str]") -> None:
        self._words = bytearray()
        self._reader = Thread(target=self._read, args=(process,), daemon=True)
        self._reader.start()

    def text(self) -> str:
        """Return the words, once the process has ended."""
        self._reader.join()
        return self._words.decode(errors="replace").strip()

    def _read(self, process: "subprocess.Popen[str]") -> None:
        assert process.stderr is not None
        while part := os.read(process.stderr.fileno(), _SAID_BYTES):
            self._words += part
            del self._words[:-_SAID_BYTES]

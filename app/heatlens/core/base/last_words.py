"""Keep the end of what another process prints on standard error."""

import os
import subprocess
from threading import Thread

_TAIL_BYTES = 65536  # how much of the end is kept


class StderrTail:
    """The end of the standard error of `process`, read on a thread so that printing never blocks.

    A library may print without end, so only the last bytes are kept. The error pipe of the process
    must be open, and nobody else may read it.
    """

    def __init__(self, process: "subprocess.Popen[bytes] | subprocess.Popen[str]") -> None:
        self._tail = bytearray()
        self._reader = Thread(target=self._read, args=(process,), daemon=True)
        self._reader.start()

    def text(self) -> str:
        """Return the end of the text; wait until the process has closed its pipe."""
        self._reader.join()
        return self._tail.decode(errors="replace").strip()

    def _read(self, process: "subprocess.Popen[bytes] | subprocess.Popen[str]") -> None:
        """Read the pipe to its end and keep its last bytes; runs on a thread."""
        assert process.stderr is not None
        while chunk := os.read(process.stderr.fileno(), _TAIL_BYTES):
            self._tail += chunk
            del self._tail[:-_TAIL_BYTES]

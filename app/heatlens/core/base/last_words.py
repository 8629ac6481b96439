"""Keep the end of what another process prints on standard error."""

import os
import subprocess
from threading import Thread

_KEPT_BYTES = 65536


class LastWords:
    """The last words of `process`, read on a thread so that it never has to wait to print.

    A library may print without end, so only the last bytes are kept. The error pipe of the process
    must be open, and nobody else may read it.
    """

    def __init__(self, process: "subprocess.Popen[bytes] | subprocess.Popen[str]") -> None:
        self._words = bytearray()
        self._reader = Thread(target=self._read, args=(process,), daemon=True)
        self._reader.start()

    def text(self) -> str:
        """Return the words; wait until the process has closed its pipe."""
        self._reader.join()
        return self._words.decode(errors="replace").strip()

    def _read(self, process: "subprocess.Popen[bytes] | subprocess.Popen[str]") -> None:
        assert process.stderr is not None
        while part := os.read(process.stderr.fileno(), _KEPT_BYTES):
            self._words += part
            del self._words[:-_KEPT_BYTES]

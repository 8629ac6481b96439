"""Remember which programs the driver of this machine has built already.

Drivers keep what they have built on disk. Building one of those programs again takes a millisecond,
a new one up to a second. A window may refuse new programs, and have another process build them.
"""

import hashlib
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path

from heatlens.core.base.errors import HeatlensError
from heatlens.core.base.paths import read_file_bytes
from heatlens.media.files.atomic_file import make_folder, write_atomically
from heatlens.render.gpu.device import Device
from heatlens.render.gpu.shader_source import ShaderSource


class NewProgramError(Exception):
    """A picture needs a program that the driver has not built yet."""


class KnownPrograms:
    """The digests of all programs that the driver has built."""

    def __init__(self) -> None:
        self.digests: set[str] = set()
        self._refuses_new = False

    @contextmanager
    def refuse_new(self, refuses: bool = True) -> Iterator[None]:
        """Raise NewProgramError for each new program in this block, if `refuses`."""
        self._refuses_new = refuses
        try:
            yield
        finally:
            self._refuses_new = False

    def add(self, sources: Sequence[ShaderSource]) -> None:
        """Note that the driver builds a program. Raises NewProgramError where that is refused."""
        text = "\0".join(source.text for source in sources)
        digest = hashlib.sha256(text.encode()).hexdigest()
        if self._refuses_new and digest not in self.digests:
            raise NewProgramError(sources[0].files[0])
        self.digests.add(digest)


KNOWN_PROGRAMS = KnownPrograms()


class ProgramsFile:
    """Keeps the digests of the known programs in a file of the cache, one for each driver."""

    def __init__(self, folder: Path, device: Device) -> None:
        driver = f"{device.library} {device.name} {device.version}"
        self._path = folder / f"{hashlib.sha256(driver.encode()).hexdigest()[:16]}.txt"

    def load(self) -> None:
        """Add the digests of the file to the known programs; without a file, none are added."""
        with suppress(OSError):
            words = read_file_bytes(self._path).decode("ascii", "replace")
            KNOWN_PROGRAMS.digests.update(words.split())

    def save(self) -> None:
        """Write the digests; a folder that cannot be written to only costs time later."""
        with suppress(OSError, HeatlensError):
            make_folder(self._path.parent, parents=True)
            write_atomically(self._path, "\n".join(sorted(KNOWN_PROGRAMS.digests)).encode())

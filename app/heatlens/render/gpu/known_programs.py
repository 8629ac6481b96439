"""Remember which programs the driver of a device has built already.

Drivers keep what they have built on disk. Building one of those programs again takes a millisecond,
a new one up to a second. A window may refuse new programs, and have another process build them.
"""

import hashlib
from collections.abc import Iterator, Sequence
from contextlib import contextmanager

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

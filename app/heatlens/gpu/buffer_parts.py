"""Divide a storage buffer into equal parts that can be bound like separate buffers."""

from dataclasses import dataclass

import moderngl

_ALIGNED = 256  # every driver can bind a part that begins at a multiple of this


@dataclass(frozen=True)
class BufferPart:
    """The `size` bytes of a buffer from the byte `first` on."""

    whole: moderngl.Buffer
    first: int
    size: int

    def bind_to_storage_buffer(self, unit: int) -> None:
        """Bind the part; `moderngl.Buffer` has the same method."""
        self.whole.bind_to_storage_buffer(unit, self.first, self.size)

    def read(self) -> bytes:
        """Return the content of the part."""
        return self.whole.read(self.size, offset=self.first)


@dataclass(frozen=True)
class BufferParts:
    """A buffer as parts of `part_bytes` each."""

    whole: moderngl.Buffer
    part_bytes: int

    @staticmethod
    def bytes_for(least: int) -> int:
        """Return the size of a part that has room for at least `least` bytes."""
        return -(-least // _ALIGNED) * _ALIGNED

    @property
    def words(self) -> int:
        """The number of 32-bit words of a part."""
        return self.part_bytes // 4

    def __getitem__(self, number: int) -> BufferPart:
        return BufferPart(self.whole, number * self.part_bytes, self.part_bytes)

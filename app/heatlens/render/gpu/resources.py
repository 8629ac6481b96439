"""Abstract types of the textures and buffers of a graphics device."""

from abc import ABC, abstractmethod
from dataclasses import dataclass
from enum import Enum, auto
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

Data: TypeAlias = bytes | bytearray | memoryview | npt.NDArray[np.generic]
Area = tuple[int, int, int, int]  # x, y, width and height in pixels


class Sampling(Enum):
    """How a shader samples a texture between its texels, and when it is drawn smaller."""

    NEAREST = auto()
    LINEAR = auto()
    MIPMAPPED = auto()  # linear, and from smaller levels where it is drawn smaller


class Sampled(ABC):
    """An image that a shader can sample.

    components  channels per texel, each of the type `dtype`
    repeats     the image is repeated beyond its edge; else the edge is clamped
    """

    width: int
    height: int
    components: int
    dtype: str
    label: str
    sampling: Sampling
    repeats: bool

    @property
    @abstractmethod
    def is_released(self) -> bool:
        """True once its memory was released."""

    @abstractmethod
    def write(self, data: Data, viewport: Area | None = None) -> None:
        """Replace the content, row 0 first, or that of an area."""

    @abstractmethod
    def read(self) -> bytes:
        """Return the content, row 0 first."""

    @abstractmethod
    def build_mipmaps(self) -> None:
        """Make the smaller levels from the content."""

    @abstractmethod
    def fill_with_nan(self) -> None:
        """Write NaN into every texel, or the largest number if these are unsigned integers."""

    @abstractmethod
    def release(self) -> None:
        """Give the memory back."""


class Texture(Sampled):
    """A picture on the device; `size` is (width, height)."""

    size: tuple[int, int]

    @property
    @abstractmethod
    def handle(self) -> int:
        """The number by which ImGui draws it."""

    @abstractmethod
    def read(self, level: int = 0) -> bytes:
        """Return the content, row 0 first, or that of a smaller level."""

    @abstractmethod
    def read_into(self, data: Data) -> None:
        """Copy the content, row 0 first, into `data`."""


class TextureArray(Sampled):
    """Several pictures of one size; `size` is (width, height, layers)."""

    size: tuple[int, int, int]
    layers: int


class Texture3D(Sampled):
    """A lattice of values; `size` is (width, height, depth)."""

    size: tuple[int, int, int]


class Buffer(ABC):
    """Bytes on the device, for storage blocks, vertices and the commands of indirect draws."""

    size: int

    @abstractmethod
    def write(self, data: Data, offset: int = 0) -> None:
        """Replace the bytes from `offset` on."""

    @abstractmethod
    def read(self, size: int = -1, offset: int = 0) -> bytes:
        """Return `size` bytes from `offset` on; -1 for all."""

    @abstractmethod
    def clear(self) -> None:
        """Set every byte to 0."""

    @abstractmethod
    def orphan(self, size: int = -1) -> None:
        """Take new memory of `size` bytes, -1 for as many as before; the content is lost."""

    @abstractmethod
    def copy_to(self, other: "Buffer") -> None:
        """Copy all bytes to the beginning of another buffer of the device."""

    @abstractmethod
    def fill_with_nan(self) -> None:
        """Write NaN into the whole buffer."""

    @abstractmethod
    def release(self) -> None:
        """Give the memory back."""


@dataclass(frozen=True, slots=True)
class BufferPart:
    """The `size` bytes of a buffer from the byte `first` on."""

    whole: Buffer
    first: int
    size: int

    def read(self) -> bytes:
        """Return the content of the part."""
        return self.whole.read(self.size, offset=self.first)


class DepthBuffer(ABC):
    """The depths beside the colors of a framebuffer."""

    @abstractmethod
    def release(self) -> None:
        """Give the memory back."""


Image = Texture | TextureArray | Texture3D
StorageBuffer = Buffer | BufferPart

"""Abstract types of a graphics device, its textures, buffers, programs and framebuffers.

Passes use only these types. The classes that derive from them are the only ones that know a
graphics library: those for OpenGL are in `gpu/opengl`; another library can be added likewise.
"""

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass
from enum import Enum, auto
from functools import cached_property
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from heatlens.core.base.errors import GpuError
from heatlens.render.gpu.known_programs import KnownPrograms
from heatlens.render.gpu.shader_source import ShaderSource

Data: TypeAlias = bytes | bytearray | memoryview | npt.NDArray[np.generic]
Area = tuple[int, int, int, int]  # x, y, width and height in pixels


class DeviceLostError(GpuError):
    """The driver was started anew, or the device was taken away: nothing can be drawn any more."""


class DeviceError(GpuError):
    """What a graphics library refused; `reason` is in its own words, `details` all that it says."""

    def __init__(self, sentence: str, reason: str, details: str) -> None:
        super().__init__(sentence)
        self.reason, self.details = reason, details


class Sampling(Enum):
    """How a shader samples a texture between its texels, and when it is drawn smaller."""

    NEAREST = auto()
    LINEAR = auto()
    MIPMAPPED = auto()  # linear, and from smaller levels where it is drawn smaller


class Primitive(Enum):
    """What the vertices of a draw make up."""

    TRIANGLES = auto()
    TRIANGLE_STRIP = auto()


class Blend(Enum):
    """How a draw combines its color with the one in the framebuffer."""

    NONE = auto()
    ADD = auto()
    OVER = auto()  # composited by straight alpha; the alpha of the framebuffer stays


class DepthTest(Enum):
    """Which pixels of a draw are written, by their depth and the one in the framebuffer."""

    NONE = auto()
    LESS = auto()
    EQUAL = auto()
    AT_MOST = auto()
    ALWAYS = auto()


@dataclass(frozen=True, slots=True)
class Limits:
    """The largest texture side, storage buffer and workgroup that a device supports."""

    texture_side_px: int
    storage_block_bytes: int
    group_invocations: int


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


class Framebuffer(ABC):
    """Textures that draws write into, or a window of OpenGL.

    scissor        nothing outside of it is drawn or cleared; None for no limit
    writes_color, writes_depth  False leaves the colors or the depths as they are
    """

    size: tuple[int, int]
    viewport: Area
    scissor: Area | None
    writes_color: bool
    writes_depth: bool
    color_attachments: tuple[Texture, ...]

    @abstractmethod
    def use(self) -> None:
        """Let the next draws write into it."""

    @abstractmethod
    def clear(
        self, red: float = 0.0, green: float = 0.0, blue: float = 0.0, alpha: float = 0.0
    ) -> None:
        """Fill it with a color, and its depths with the farthest."""

    @abstractmethod
    def read(self, viewport: Area | None = None, components: int = 3, dtype: str = "f1") -> bytes:
        """Return the pixels of an area, row 0 first."""

    @abstractmethod
    def read_into(self, data: Data, components: int = 3) -> None:
        """Copy the pixels, row 0 first, into `data`."""

    @abstractmethod
    def release(self) -> None:
        """Give it back, but not its textures."""


Image = Texture | TextureArray | Texture3D
StorageBuffer = Buffer | BufferPart
NamedImages: TypeAlias = Mapping[str, Image] | None
NamedBuffers: TypeAlias = Mapping[str, StorageBuffer] | None
Uniforms: TypeAlias = Mapping[str, object] | None
VertexLayout: TypeAlias = Sequence[tuple[Buffer, str, *tuple[str, ...]]]


class LinkedProgram(ABC):
    """A program that the device has built."""

    @abstractmethod
    def bind(
        self, textures: NamedImages, images: NamedImages, buffers: NamedBuffers, uniforms: Uniforms
    ) -> None:
        """Bind the inputs of the next run by name; raise ShaderError for an undeclared one."""

    @abstractmethod
    def release(self) -> None:
        """Delete the program."""


class LinkedCompute(LinkedProgram):
    """A compute program; what a run has written, the next run can read."""

    @abstractmethod
    def run(self, groups: tuple[int, ...]) -> None:
        """Run on this number of workgroups along each axis."""

    @abstractmethod
    def run_indirect(self, groups: Buffer, offset: int) -> None:
        """Run on the number of workgroups that the three words at byte `offset` contain."""


class LinkedArray(ABC):
    """Buffers as the vertices of a draw program."""

    @abstractmethod
    def render(self, mode: Primitive, vertices: int) -> None:
        """Draw this number of vertices."""

    @abstractmethod
    def render_indirect(self, commands: Buffer, mode: Primitive, count: int) -> None:
        """Draw with `count` commands of the buffer."""

    @abstractmethod
    def release(self) -> None:
        """Delete it, but not the buffers."""


class LinkedDraw(LinkedProgram):
    """A program that draws vertices."""

    @abstractmethod
    def vertex_array(self, layout: VertexLayout, index: Buffer | None) -> LinkedArray:
        """Return buffers and their attributes as vertices, without the unused attributes."""


class Timer(AbstractContextManager["Timer"]):
    """Measures the time that the device takes for the work issued inside."""

    seconds: float


class Device(ABC):
    """Makes textures, buffers, programs and targets, and issues work to one GPU or rasterizer.

    library                the graphics library, for messages
    name, vendor, version  of the driver
    is_software            a rasterizer on the processor: no fast memory, and timers are wrong; a
                           test may set it to False to have what a GPU would get
    error                  the driver's error since the last time this was read; "" for none
    """

    library: str
    name: str
    vendor: str
    version: str
    limits: Limits
    is_software: bool

    @property
    @abstractmethod
    def error(self) -> str:
        """The driver's error since the last time this was read; "" for none."""

    @cached_property
    def known_programs(self) -> KnownPrograms:
        """The programs that the driver has built, as far as this process knows."""
        return KnownPrograms()

    @property
    def compiles_views(self) -> bool:
        """Whether it can compile GLSL that OpenColorIO makes for a view."""
        return True

    @abstractmethod
    def texture(
        self, size: tuple[int, int], components: int, data: Data | None = None, dtype: str = "f1"
    ) -> Texture:
        """Make a texture, sampled linearly and repeated."""

    @abstractmethod
    def texture_array(
        self,
        size: tuple[int, int, int],
        components: int,
        data: Data | None = None,
        dtype: str = "f1",
    ) -> TextureArray:
        """Make an array of textures."""

    @abstractmethod
    def texture3d(
        self,
        size: tuple[int, int, int],
        components: int,
        data: Data | None = None,
        dtype: str = "f1",
    ) -> Texture3D:
        """Make a texture in three dimensions."""

    @abstractmethod
    def shadow_map(self, size: tuple[int, int]) -> Texture:
        """Make a texture of depths, which answers comparisons, blended between four texels."""

    @abstractmethod
    def depth_buffer(self, size: tuple[int, int]) -> DepthBuffer:
        """Make a buffer for the depths of a framebuffer."""

    @abstractmethod
    def buffer(self, data: Data | None = None, reserve: int = 0) -> Buffer:
        """Make a buffer with `data` as its content, or of `reserve` bytes."""

    @abstractmethod
    def framebuffer(
        self, colors: Sequence[Texture] = (), depth: DepthBuffer | Texture | None = None
    ) -> Framebuffer:
        """Make a framebuffer that draws into textures, the first one as output 0."""

    @abstractmethod
    def simple_framebuffer(self, size: tuple[int, int]) -> Framebuffer:
        """Make a framebuffer with memory of its own."""

    @abstractmethod
    def copy_framebuffer(self, target: Framebuffer, source: Framebuffer) -> None:
        """Copy the pixels of one framebuffer into another."""

    @abstractmethod
    def compute_program(self, source: ShaderSource) -> LinkedCompute:
        """Build a compute program. Raises ShaderError with the driver's log."""

    @abstractmethod
    def draw_program(self, vertex: ShaderSource, fragment: ShaderSource) -> LinkedDraw:
        """Build a program that draws. Raises ShaderError with the driver's log."""

    @abstractmethod
    def draw_with(self, blend: Blend = Blend.NONE, depth: DepthTest = DepthTest.NONE) -> None:
        """Let the next draws blend and compare depths in this way."""

    @abstractmethod
    def timer(self) -> Timer:
        """Return a timer, whose seconds are wrong where the device is software."""

    @abstractmethod
    def finish(self) -> None:
        """Wait until all work is done."""

    @abstractmethod
    def make_current(self) -> None:
        """Direct the calls of this thread to this device, if a program has several."""

    @abstractmethod
    def release(self) -> None:
        """Give the device back."""

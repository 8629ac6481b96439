"""The abstract type of a graphics device, and its errors.

Passes use only this type and those of `resources.py`, `framebuffer.py` and `linked_program.py`. The
classes that derive from these are the only ones that know a graphics library: `gpu/opengl` and
`gpu/wgpu`.
"""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass
from functools import cached_property

from heatlens.core.base.errors import GpuError
from heatlens.render.gpu.framebuffer import Blend, DepthTest, Framebuffer
from heatlens.render.gpu.known_programs import KnownPrograms
from heatlens.render.gpu.linked_program import LinkedCompute, LinkedDraw
from heatlens.render.gpu.resources import (
    Buffer,
    Data,
    DepthBuffer,
    Texture,
    Texture3D,
    TextureArray,
)
from heatlens.render.gpu.shader_source import ShaderSource


class DeviceLostError(GpuError):
    """The driver was started anew, or the device was taken away: nothing can be drawn any more."""


class DeviceError(GpuError):
    """What a graphics library refused; `reason` is in its own words, `details` all that it says."""

    def __init__(self, sentence: str, reason: str, details: str) -> None:
        super().__init__(sentence)
        self.reason, self.details = reason, details


@dataclass(frozen=True, slots=True)
class Limits:
    """The largest texture side, storage buffer and workgroup that a device supports."""

    texture_side_px: int
    storage_block_bytes: int
    group_invocations: int


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

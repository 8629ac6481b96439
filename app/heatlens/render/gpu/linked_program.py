"""Abstract types of the programs that a device has built."""

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from typing import TypeAlias

from heatlens.render.gpu.framebuffer import Primitive
from heatlens.render.gpu.resources import Buffer, Image, StorageBuffer

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

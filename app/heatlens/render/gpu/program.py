"""Shader programs that take all inputs by name, in one call.

A name that the shader's text does not declare is a ShaderError. A name that is declared, but that
the compiler removed as unused, is ignored. With HEATLENS_STRICT_SHADERS=1 in the environment, which
the tests set, an input that the compiler kept and that was never given is a ShaderError too.
"""

from collections.abc import Mapping, Sequence
from typing import Generic, Self, TypeAlias, TypeVar

from heatlens.core.base.paths import data_dir
from heatlens.render.gpu import shader_reload
from heatlens.render.gpu.device import Device
from heatlens.render.gpu.framebuffer import Primitive
from heatlens.render.gpu.linked_program import LinkedArray, LinkedCompute, LinkedDraw, VertexLayout
from heatlens.render.gpu.resources import Buffer, BufferPart, Image, StorageBuffer
from heatlens.render.gpu.shader_constants import PIXEL_GROUP
from heatlens.render.gpu.shader_source import ShaderSource, assemble

Defines: TypeAlias = Mapping[str, object]
Linked = TypeVar("Linked", LinkedCompute, LinkedDraw)


class _Program(Generic[Linked]):
    """A program that is built from its files on first use, and can be built again."""

    build_count = 0  # number of programs built in this process

    def __init__(self, ctx: Device, defines: Defines | None) -> None:
        self._ctx, self._defines = ctx, dict(defines or {})
        self._versions: dict[frozenset[tuple[str, object]], Self] = {}
        self._built: Linked | None = None
        self._files = frozenset[str]()
        shader_reload.watch(self)

    def version(self, **defines: object) -> Self:
        """Return the program with more defines; True stands for 1, and False for no define.

        The same defines give the same program.
        """
        added = {
            name: 1 if value is True else value
            for name, value in defines.items()
            if value is not False
        }
        key = frozenset(added.items())
        if not added:
            return self
        if key not in self._versions:
            self._versions[key] = self._with(self._defines | added)
        return self._versions[key]

    def _with(self, defines: Defines) -> Self:
        """Return a program of the same files with other defines."""
        raise NotImplementedError

    def _sources(self) -> Sequence[ShaderSource]:
        """Read the texts of the stages again."""
        raise NotImplementedError

    def _compile(self, sources: Sequence[ShaderSource]) -> Linked:
        """Compile and link the stages on the device."""
        raise NotImplementedError

    def link(self) -> Linked:
        """Return the program of the device, which `rebuild` replaces.

        Raises ShaderError with the driver's log, in which positions are given as file and line.
        """
        return self._build() if self._built is None else self._built

    def _build(self) -> Linked:
        """Build the program from the current files, and remember which files it came from."""
        sources = self._sources()
        self._ctx.known_programs.add(sources)
        self._built = self._compile(sources)
        _Program.build_count += 1
        self._files = frozenset(file for source in sources for file in source.files)
        return self._built

    @property
    def files(self) -> frozenset[str]:
        """The files that the text came from, relative to the folder of shaders; none before."""
        return self._files

    def rebuild(self) -> None:
        """Build from the current files; raise ShaderError and keep the old build on failure."""
        previous = self._built
        self._build()
        if previous is not None:
            previous.release()

    def release(self) -> None:
        """Delete the program and its versions; one that is used again is built again."""
        if self._built is not None:
            self._built.release()
        self._built, self._files = None, frozenset()
        while self._versions:
            self._versions.popitem()[1].release()


class ComputeProgram(_Program[LinkedCompute]):
    """One compute shader."""

    def __init__(
        self,
        ctx: Device,
        name: str,
        defines: Defines | None = None,
        functions: str = "",
    ) -> None:
        """Take the shader file `name`.

        `functions` is generated GLSL that defines functions which the file only declares.
        """
        self.name, self._functions = name, functions
        super().__init__(ctx, defines)

    def _with(self, defines: Defines) -> "ComputeProgram":
        return ComputeProgram(self._ctx, self.name, defines, self._functions)

    def _sources(self) -> Sequence[ShaderSource]:
        source = assemble(data_dir("shaders"), self.name, self._defines)
        return [source.append_functions(self._functions) if self._functions else source]

    def _compile(self, sources: Sequence[ShaderSource]) -> LinkedCompute:
        return self._ctx.compute_program(sources[0])

    def dispatch(
        self,
        groups: tuple[int, ...] | StorageBuffer,
        *,
        offset: int = 0,
        textures: Mapping[str, Image] | None = None,
        images: Mapping[str, Image] | None = None,
        buffers: Mapping[str, StorageBuffer] | None = None,
        uniforms: Mapping[str, object] | None = None,
    ) -> None:
        """Run on `groups` workgroups; if that is a buffer, its words at byte `offset` are counts.

        Raises ShaderError as `link`, and for a name that is not declared.
        """
        program = self.link()
        program.bind(textures, images, buffers, uniforms)
        if isinstance(groups, tuple):
            program.run(groups)
        elif isinstance(groups, BufferPart):
            program.run_indirect(groups.whole, offset + groups.first)
        else:
            program.run_indirect(groups, offset)


class DrawProgram(_Program[LinkedDraw]):
    """A vertex and a fragment shader linked together."""

    def __init__(
        self,
        ctx: Device,
        name: str,
        fragment: str | None = None,
        defines: Defines | None = None,
    ) -> None:
        """Take `name`.vert.glsl with `fragment`.frag.glsl; `fragment` defaults to `name`."""
        self._name, self._fragment = name, fragment or name
        super().__init__(ctx, defines)

    def _with(self, defines: Defines) -> "DrawProgram":
        return DrawProgram(self._ctx, self._name, self._fragment, defines)

    def _sources(self) -> Sequence[ShaderSource]:
        folder = data_dir("shaders")
        names = f"{self._name}.vert.glsl", f"{self._fragment}.frag.glsl"
        return [assemble(folder, name, self._defines) for name in names]

    def _compile(self, sources: Sequence[ShaderSource]) -> LinkedDraw:
        vertex, fragment = sources
        return self._ctx.draw_program(vertex, fragment)

    def vertex_array(self, layout: VertexLayout, index: Buffer | None = None) -> "VertexArray":
        """Return a vertex array of buffers and their attributes, without the unused ones."""
        return VertexArray(self, layout, index)

    def bind(
        self,
        *,
        textures: Mapping[str, Image] | None = None,
        uniforms: Mapping[str, object] | None = None,
        buffers: Mapping[str, StorageBuffer] | None = None,
    ) -> None:
        """Bind the inputs of the next draw. Raises ShaderError as `ComputeProgram.dispatch`."""
        self.link().bind(textures, None, buffers, uniforms)


class VertexArray:
    """The vertex array of a draw program, made on first use and again after a rebuild."""

    def __init__(self, program: DrawProgram, layout: VertexLayout, index: Buffer | None) -> None:
        self._program, self._layout, self._index = program, list(layout), index
        self._built_for: LinkedDraw | None = None
        self._built_array: LinkedArray | None = None

    @property
    def _current_array(self) -> LinkedArray:
        """The vertex array of the current program."""
        linked = self._program.link()
        if self._built_array is None or self._built_for is not linked:
            self.release()
            self._built_for = linked
            self._built_array = linked.vertex_array(self._layout, self._index)
        return self._built_array

    def render(self, mode: Primitive, vertices: int) -> None:
        """Draw `vertices` vertices."""
        self._current_array.render(mode, vertices)

    def render_indirect(self, commands: Buffer, mode: Primitive, count: int) -> None:
        """Draw with `count` indirect commands in the buffer `commands`."""
        self._current_array.render_indirect(commands, mode, count)

    def release(self) -> None:
        """Delete the vertex array, but not the buffers, which belong to the caller."""
        if self._built_array is not None:
            self._built_array.release()


def pixel_groups(size: tuple[int, int]) -> tuple[int, int]:
    """Return the workgroups of PIXEL_GROUP by PIXEL_GROUP pixels that cover a picture."""
    return blocks_for(size, PIXEL_GROUP)


def blocks_for(size: tuple[int, int], side: int) -> tuple[int, int]:
    """Return how many square blocks of `side` pixels cover a picture, across and down."""
    return groups_for(size[0], side), groups_for(size[1], side)


def groups_for(size: int, per_group: int) -> int:
    """Return how many groups of `per_group` cover `size`."""
    return -(-size // per_group)


def programs_built() -> int:
    """Return how many programs this process has built; building one can take 0.1 s and more."""
    return _Program.build_count

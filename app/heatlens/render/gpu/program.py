"""Shader programs that take all inputs by name, in one call.

A name that the shader's text does not declare is a ShaderError. A name that is declared, but that
the compiler removed as unused, is ignored. With HEATLENS_STRICT_SHADERS=1 in the environment, which
the tests set, an input that the compiler kept and that was never given is a ShaderError too.
"""

from collections.abc import Mapping, Sequence

from heatlens.core.base.paths import data_dir
from heatlens.render.gpu import shader_reload
from heatlens.render.gpu.device import Device
from heatlens.render.gpu.framebuffer import Primitive
from heatlens.render.gpu.linked_program import LinkedArray, LinkedCompute, LinkedDraw, VertexLayout
from heatlens.render.gpu.resources import Buffer, BufferPart, Image, StorageBuffer
from heatlens.render.gpu.shader_constants import PIXEL_GROUP
from heatlens.render.gpu.shader_source import ShaderSource, assemble


class _Program:
    """A linked program that can be built again from its files."""

    build_count = 0  # number of programs built in this process

    def __init__(self, ctx: Device) -> None:
        self._ctx = ctx
        self._build()
        shader_reload.watch(self)

    def _sources(self) -> Sequence[ShaderSource]:
        """Read the texts of the stages again."""
        raise NotImplementedError

    def _link(self, sources: Sequence[ShaderSource]) -> LinkedCompute | LinkedDraw:
        """Compile and link the stages on the device."""
        raise NotImplementedError

    def _build(self) -> None:
        """Build the program from the current files, and remember which files it came from."""
        sources = self._sources()
        self._ctx.known_programs.add(sources)
        self._program = self._link(sources)
        _Program.build_count += 1
        self._files = frozenset(file for source in sources for file in source.files)

    @property
    def files(self) -> frozenset[str]:
        """The files that the text came from, relative to the folder of shaders."""
        return self._files

    def rebuild(self) -> None:
        """Build from the current files; raise ShaderError and keep the old build on failure."""
        previous = self._program
        self._build()
        previous.release()

    def release(self) -> None:
        """Delete the program."""
        shader_reload.forget(self)
        self._program.release()


class ComputeProgram(_Program):
    """One compiled compute shader."""

    _program: LinkedCompute

    def __init__(
        self,
        ctx: Device,
        name: str,
        defines: Mapping[str, object] | None = None,
        functions: str = "",
    ) -> None:
        """Compile the shader file `name`.

        `functions` is generated GLSL that defines functions which the file only declares. Raises
        ShaderError with the driver's log, in which positions are given as file and line.
        """
        self.name = name
        self._defines, self._functions = defines, functions
        super().__init__(ctx)

    def _sources(self) -> Sequence[ShaderSource]:
        source = assemble(data_dir("shaders"), self.name, self._defines)
        return [source.append_functions(self._functions) if self._functions else source]

    def _link(self, sources: Sequence[ShaderSource]) -> LinkedCompute:
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

        Raises ShaderError for a name that is not declared.
        """
        self._program.bind(textures, images, buffers, uniforms)
        if isinstance(groups, tuple):
            self._program.run(groups)
        elif isinstance(groups, BufferPart):
            self._program.run_indirect(groups.whole, offset + groups.first)
        else:
            self._program.run_indirect(groups, offset)


class ComputePrograms:
    """Compute programs by shader file and defines, each built when it is first used."""

    def __init__(self, ctx: Device) -> None:
        self._ctx = ctx
        self._built: dict[tuple[str, frozenset[tuple[str, object]]], ComputeProgram] = {}

    def get(self, name: str, defines: Mapping[str, object] | None = None) -> ComputeProgram:
        """Return the program of the shader file `name`. Raises ShaderError as `ComputeProgram`."""
        key = name, frozenset((defines or {}).items())
        if key not in self._built:
            self._built[key] = ComputeProgram(self._ctx, name, defines)
        return self._built[key]

    def release(self) -> None:
        """Delete the programs; one that is used again is built again."""
        while self._built:
            self._built.popitem()[1].release()


class DrawProgram(_Program):
    """A vertex and a fragment shader linked together."""

    _program: LinkedDraw

    def __init__(
        self,
        ctx: Device,
        name: str,
        fragment: str | None = None,
        defines: Mapping[str, object] | None = None,
    ) -> None:
        """Link `name`.vert.glsl with `fragment`.frag.glsl; `fragment` defaults to `name`.

        Raises ShaderError with the driver's log, in which positions are given as file and line.
        """
        self._names = f"{name}.vert.glsl", f"{fragment or name}.frag.glsl"
        self._defines = defines
        super().__init__(ctx)

    def _sources(self) -> Sequence[ShaderSource]:
        folder = data_dir("shaders")
        return [assemble(folder, name, self._defines) for name in self._names]

    def _link(self, sources: Sequence[ShaderSource]) -> LinkedDraw:
        vertex, fragment = sources
        return self._ctx.draw_program(vertex, fragment)

    def vertex_array(self, layout: VertexLayout, index: Buffer | None = None) -> "VertexArray":
        """Return a vertex array of buffers and their attributes, without the unused ones."""
        return VertexArray(self, layout, index)

    @property
    def linked(self) -> LinkedDraw:
        """The current program of the device; `rebuild` replaces it."""
        return self._program

    def bind(
        self,
        *,
        textures: Mapping[str, Image] | None = None,
        uniforms: Mapping[str, object] | None = None,
        buffers: Mapping[str, StorageBuffer] | None = None,
    ) -> None:
        """Bind the inputs of the next draw; raise ShaderError for a name that is not declared."""
        self._program.bind(textures, None, buffers, uniforms)


class VertexArray:
    """The vertex array of a draw program, which is made again when the program is rebuilt."""

    def __init__(self, program: DrawProgram, layout: VertexLayout, index: Buffer | None) -> None:
        self._program, self._layout, self._index = program, list(layout), index
        self._built_for = program.linked
        self._built_array = self._built_for.vertex_array(self._layout, index)

    @property
    def _current_array(self) -> LinkedArray:
        """The vertex array of the current program, made again after a rebuild."""
        if self._built_for is not self._program.linked:
            previous, self._built_for = self._built_array, self._program.linked
            self._built_array = self._built_for.vertex_array(self._layout, self._index)
            previous.release()
        return self._built_array

    def render(self, mode: Primitive, vertices: int) -> None:
        """Draw `vertices` vertices."""
        self._current_array.render(mode, vertices)

    def render_indirect(self, commands: Buffer, mode: Primitive, count: int) -> None:
        """Draw with `count` indirect commands in the buffer `commands`."""
        self._current_array.render_indirect(commands, mode, count)

    def release(self) -> None:
        """Delete the vertex array, but not the buffers, which belong to the caller."""
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

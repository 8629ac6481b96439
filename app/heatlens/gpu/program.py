"""Shader programs that take all inputs by name, in one call.

A name that the shader's text does not declare is a ShaderError. A name that is declared, but that
the compiler removed as unused, is ignored. With HEATLENS_STRICT_SHADERS=1 in the environment, which
the tests set, an input that the compiler kept and that was never given is a ShaderError too.
"""

import os
from collections.abc import Callable, Iterable, Mapping, Sequence

import moderngl

from heatlens.base.errors import ShaderError
from heatlens.base.paths import data_dir
from heatlens.base.stopping import uninterrupted
from heatlens.gpu import shader_reload
from heatlens.gpu.shader_constants import PIXEL_GROUP
from heatlens.gpu.shader_source import Kind, ShaderSource, assemble, declared_in
from heatlens.gpu.textures import BufferPart

STRICT_VARIABLE = "HEATLENS_STRICT_SHADERS"

Image = moderngl.Texture | moderngl.TextureArray | moderngl.Texture3D
StorageBuffer = moderngl.Buffer | BufferPart
_Linked = moderngl.ComputeShader | moderngl.Program
_WITH_UNITS: tuple[Kind, ...] = ("sampler", "image", "storage block")
# The types of image2DArray, iimage2DArray and uimage2DArray. moderngl 5.13 cannot set their unit,
# so that they must have the one that OpenGL gives them first, 0.
_IMAGE_ARRAYS = (0x9053, 0x905E, 0x9069)


class _Inputs:
    """The inputs of a linked program, and the binding units of each.

    Samplers, images and storage blocks get their units here, once; binding numbers in the shader's
    text are ignored.
    """

    def __init__(self, linked: _Linked, sources: Sequence[ShaderSource]) -> None:
        self._linked, self._names = linked, frozenset(linked)  # lookups in `linked` itself are slow
        self._declared = declared_in(sources)
        self._units: dict[str, int] = {}
        for kind in _WITH_UNITS:
            names = self._declared.of_kind(kind)
            self._give_units(sorted((n for n in linked if n in names), key=self._is_settable))
        self._is_strict = bool(os.environ.get(STRICT_VARIABLE))
        self._unset = {n for n in linked if self._declared.kinds.get(n) == "uniform"}
        self._last: dict[str, object] = {}  # the values of the uniforms, which the program keeps

    def _is_settable(self, name: str) -> bool:
        return getattr(self._linked[name], "gl_type", None) not in _IMAGE_ARRAYS

    def _give_units(self, names: Iterable[str]) -> None:
        for unit, name in enumerate(names):
            member = self._linked[name]
            if isinstance(member, moderngl.StorageBlock):
                member.binding = unit
            elif self._is_settable(name):
                self._linked[name] = unit
            elif unit:
                raise ShaderError(f"{', '.join(self._declared.files)}: two arrays of images.")
            self._units[name] = unit

    def bind(
        self,
        textures: Mapping[str, Image] | None,
        images: Mapping[str, Image] | None,
        buffers: Mapping[str, StorageBuffer] | None,
        uniforms: Mapping[str, object] | None,
    ) -> None:
        """Bind the inputs and outputs of the program's next run."""
        textures, images, buffers = textures or {}, images or {}, buffers or {}
        for name, texture in textures.items():
            if (unit := self._unit_of(name, "sampler")) is not None:
                texture.use(unit)
        for name, image in images.items():
            if (unit := self._unit_of(name, "image")) is not None:
                image.bind_to_image(unit)
        for name, buffer in buffers.items():
            if (unit := self._unit_of(name, "storage block")) is not None:
                buffer.bind_to_storage_buffer(unit)
        self._set(uniforms or {})
        if self._is_strict:
            self._check_all_given(textures.keys() | images.keys() | buffers.keys())

    def _unit_of(self, name: str, kind: Kind) -> int | None:
        """Return the unit of an input; None if the compiler removed it as unused."""
        unit = self._units.get(name)
        if unit is None or self._is_strict:
            self._declared.check(name, kind)
        return unit

    def _set(self, uniforms: Mapping[str, object]) -> None:
        """Set the uniforms whose values have changed; checking and setting take most of a pass."""
        for name, value in uniforms.items():
            if name in self._last and self._last[name] == value:
                continue
            self._declared.check(name, "uniform")
            if isinstance(value, int | float | tuple):  # others may be changed in place
                self._last[name] = value
            if name in self._names:
                self._linked[name] = value
                self._unset.discard(name)

    def _check_all_given(self, bound: set[str]) -> None:
        """Check that every input with a unit is given, because all programs share the units."""
        missing = sorted((self._units.keys() - bound) | self._unset)
        if missing:
            names = ", ".join(missing)
            files = " and ".join(self._declared.files)
            raise ShaderError(f"{files}: declared and used, but never given: {names}.")


class _Program:
    """A linked program, its inputs, and the way to build it again from its files."""

    built = 0  # programs built in this process so far

    def __init__(self, ctx: moderngl.Context) -> None:
        self._ctx = ctx
        self._take_built()
        shader_reload.watch(self)

    def _sources(self) -> Sequence[ShaderSource]:
        """Read the texts of the stages again."""
        raise NotImplementedError

    def _link(self, sources: Sequence[ShaderSource]) -> _Linked:
        raise NotImplementedError

    def _take_built(self) -> None:
        sources = self._sources()
        self._program = self._link(sources)
        _Program.built += 1
        self._inputs = _Inputs(self._program, sources)
        self._files = frozenset(file for source in sources for file in source.files)

    @property
    def files(self) -> frozenset[str]:
        """The files that the text came from, relative to the folder of shaders."""
        return self._files

    def rebuild(self) -> None:
        """Build from the current files; raise ShaderError and keep the old build on failure."""
        before = self._program
        self._take_built()
        before.release()

    def release(self) -> None:
        """Delete the program."""
        shader_reload.forget(self)
        self._program.release()


class ComputeProgram(_Program):
    """One compiled compute shader."""

    _program: moderngl.ComputeShader

    def __init__(
        self,
        ctx: moderngl.Context,
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
        return [source.followed_by(self._functions) if self._functions else source]

    def _link(self, sources: Sequence[ShaderSource]) -> moderngl.ComputeShader:
        return _compiled(self._ctx, sources[0])

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
        """Run on `groups` workgroups, or as many as three words of a buffer say, at `offset` bytes.

        Raises ShaderError for a name that is not declared.
        """
        self._inputs.bind(textures, images, buffers, uniforms)
        if isinstance(groups, tuple):
            self._program.run(*groups)
        elif isinstance(groups, BufferPart):
            self._program.run_indirect(groups.whole, offset + groups.first)
        else:
            self._program.run_indirect(groups, offset)
        self._ctx.memory_barrier()


class DrawProgram(_Program):
    """A vertex and a fragment shader linked together."""

    _program: moderngl.Program

    def __init__(
        self,
        ctx: moderngl.Context,
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

    def _link(self, sources: Sequence[ShaderSource]) -> moderngl.Program:
        vertex, fragment = sources
        return _linked(self._ctx, vertex, fragment)

    def vertex_array(
        self,
        layout: Sequence[tuple[moderngl.Buffer, str, *tuple[str, ...]]],
        index: moderngl.Buffer | None = None,
    ) -> "VertexArray":
        """Return a vertex array of buffers and their attributes, without the unused ones."""
        return VertexArray(self, lambda linked: self._array_for(linked, layout, index))

    def _array_for(
        self,
        linked: moderngl.Program,
        layout: Sequence[tuple[moderngl.Buffer, str, *tuple[str, ...]]],
        index: moderngl.Buffer | None,
    ) -> moderngl.VertexArray:
        return self._ctx.vertex_array(linked, list(layout), index, skip_errors=True)

    @property
    def linked(self) -> moderngl.Program:
        """The current program of OpenGL; `rebuild` replaces it."""
        return self._program

    def bind(
        self,
        *,
        textures: Mapping[str, Image] | None = None,
        uniforms: Mapping[str, object] | None = None,
        buffers: Mapping[str, StorageBuffer] | None = None,
    ) -> None:
        """Bind the inputs of the next draw; raise ShaderError for a name that is not declared."""
        self._inputs.bind(textures, None, buffers, uniforms)


class VertexArray:
    """The vertex array of a draw program, which is made again when the program is rebuilt."""

    def __init__(
        self, program: DrawProgram, make: Callable[[moderngl.Program], moderngl.VertexArray]
    ) -> None:
        self._program, self._make = program, make
        self._made_for = program.linked
        self._made = make(self._made_for)

    @property
    def _array(self) -> moderngl.VertexArray:
        if self._made_for is not self._program.linked:
            before, self._made_for = self._made, self._program.linked
            self._made = self._make(self._made_for)
            before.release()
        return self._made

    def render(self, mode: int, vertices: int) -> None:
        """Draw `vertices` vertices; `mode` is moderngl's."""
        self._array.render(mode, vertices)

    def render_indirect(self, commands: moderngl.Buffer, mode: int, count: int) -> None:
        """Draw with `count` indirect commands in the buffer `commands`."""
        self._array.render_indirect(commands, mode, count)

    def release(self) -> None:
        """Delete the vertex array, but not the buffers, which belong to the caller."""
        self._made.release()


def _compiled(ctx: moderngl.Context, source: ShaderSource) -> moderngl.ComputeShader:
    try:
        with uninterrupted():
            return ctx.compute_shader(source.text)
    except moderngl.Error as error:
        raise ShaderError(f"{source.files[0]}: {source.explained(str(error))}") from error


def _linked(
    ctx: moderngl.Context, vertex: ShaderSource, fragment: ShaderSource
) -> moderngl.Program:
    try:
        with uninterrupted():
            return ctx.program(vertex_shader=vertex.text, fragment_shader=fragment.text)
    except moderngl.Error as error:
        refused = fragment if "fragment_shader" in str(error) else vertex
        raise ShaderError(f"{refused.files[0]}: {refused.explained(str(error))}") from error


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
    return _Program.built

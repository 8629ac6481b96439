"""Shader programs whose inputs are given by name, all of them in one call.

A name that the shader's text does not declare is a ShaderError; a name that is declared, but that
the compiler removed as unused, is ignored. With HEATLENS_STRICT_SHADERS=1 in the environment, as in
the tests, an input that the compiler kept and that was never given is a ShaderError too.
"""

import os
from collections.abc import Iterable, Mapping, Sequence

import moderngl

from heatlens.errors import ShaderError
from heatlens.gpu.declared_inputs import Kind, declared_in
from heatlens.gpu.shader_constants import PIXEL_GROUP
from heatlens.gpu.shader_source import ShaderSource, assemble
from heatlens.gpu.uninterrupted import uninterrupted
from heatlens.paths import data_dir

STRICT_VARIABLE = "HEATLENS_STRICT_SHADERS"

Image = moderngl.Texture | moderngl.TextureArray | moderngl.Texture3D
_Linked = moderngl.ComputeShader | moderngl.Program
_WITH_UNITS: tuple[Kind, ...] = ("sampler", "image", "storage block")


class _Inputs:
    """The inputs of a linked program: which there are, and how each is given.

    Samplers, images and storage blocks get their units here, once; numbers in the shader's text
    do not count.
    """

    def __init__(self, linked: _Linked, sources: Sequence[ShaderSource]) -> None:
        self._linked = linked
        self._declared = declared_in(
            (source.files[0] for source in sources), (source.text for source in sources)
        )
        self._units: dict[str, int] = {}
        for kind in _WITH_UNITS:
            names = self._declared.of_kind(kind)
            self._give_units(name for name in linked if name in names)
        self._is_strict = bool(os.environ.get(STRICT_VARIABLE))
        self._unset = {n for n in linked if self._declared.kinds.get(n) == "uniform"}

    def _give_units(self, names: Iterable[str]) -> None:
        for unit, name in enumerate(names):
            member = self._linked[name]
            if isinstance(member, moderngl.StorageBlock):
                member.binding = unit
            else:
                self._linked[name] = unit
            self._units[name] = unit

    def bind(
        self,
        textures: Mapping[str, Image] | None,
        images: Mapping[str, Image] | None,
        buffers: Mapping[str, moderngl.Buffer] | None,
        uniforms: Mapping[str, object] | None,
    ) -> None:
        """Give the program what its next run reads and writes."""
        textures, images, buffers = textures or {}, images or {}, buffers or {}
        for name, texture in textures.items():
            self._declared.check(name, "sampler")
            if name in self._units:
                texture.use(self._units[name])
        for name, image in images.items():
            self._declared.check(name, "image")
            if name in self._units:
                image.bind_to_image(self._units[name])
        for name, buffer in buffers.items():
            self._declared.check(name, "storage block")
            if name in self._units:
                buffer.bind_to_storage_buffer(self._units[name])
        self._set(uniforms or {})
        if self._is_strict:
            self._check_all_given(textures.keys() | images.keys() | buffers.keys())

    def _set(self, uniforms: Mapping[str, object]) -> None:
        for name, value in uniforms.items():
            self._declared.check(name, "uniform")
            if name in self._linked:
                self._linked[name] = value
                self._unset.discard(name)

    def _check_all_given(self, bound: set[str]) -> None:
        """Units are shared by all programs, so what has one is given for each run."""
        missing = sorted((self._units.keys() - bound) | self._unset)
        if missing:
            names = ", ".join(missing)
            files = " and ".join(self._declared.files)
            raise ShaderError(f"{files}: declared and used, but never given: {names}.")


class ComputeProgram:
    """One compiled compute shader."""

    def __init__(
        self,
        ctx: moderngl.Context,
        name: str,
        defines: Mapping[str, object] | None = None,
        functions: str = "",
    ) -> None:
        """Compile the shader file `name`.

        `functions` is GLSL made elsewhere: what the file declares and leaves undefined. Raises
        ShaderError with the driver's log, its places as file and line.
        """
        self.name = name
        self._ctx = ctx
        source = assemble(data_dir("shaders"), name, defines)
        source = source.followed_by(functions) if functions else source
        self._program = _compiled(ctx, source)
        self._inputs = _Inputs(self._program, [source])

    def dispatch(
        self,
        groups: tuple[int, int] | tuple[int, int, int],
        *,
        textures: Mapping[str, Image] | None = None,
        images: Mapping[str, Image] | None = None,
        buffers: Mapping[str, moderngl.Buffer] | None = None,
        uniforms: Mapping[str, object] | None = None,
    ) -> None:
        """Run on `groups` workgroups; raise ShaderError for a name that is not declared."""
        self._inputs.bind(textures, images, buffers, uniforms)
        self._program.run(*groups)
        self._ctx.memory_barrier()

    def dispatch_indirect(
        self,
        groups: moderngl.Buffer,
        *,
        offset: int = 0,
        textures: Mapping[str, Image] | None = None,
        images: Mapping[str, Image] | None = None,
        buffers: Mapping[str, moderngl.Buffer] | None = None,
        uniforms: Mapping[str, object] | None = None,
    ) -> None:
        """Run on as many workgroups as three words of `groups` say, `offset` bytes in."""
        self._inputs.bind(textures, images, buffers, uniforms)
        self._program.run_indirect(groups, offset)
        self._ctx.memory_barrier()

    def release(self) -> None:
        """Give the program back to OpenGL."""
        self._program.release()


class DrawProgram:
    """A vertex and a fragment shader linked together."""

    def __init__(
        self,
        ctx: moderngl.Context,
        name: str,
        fragment: str | None = None,
        defines: Mapping[str, object] | None = None,
    ) -> None:
        """Link `name`.vert.glsl with `fragment`.frag.glsl, which is called `name` too if None.

        Raises ShaderError with the driver's log, its places as file and line.
        """
        self._ctx = ctx
        folder = data_dir("shaders")
        files = f"{name}.vert.glsl", f"{fragment or name}.frag.glsl"
        vertex, fragments = (assemble(folder, file, defines) for file in files)
        self._program = _linked(ctx, vertex, fragments)
        self._inputs = _Inputs(self._program, [vertex, fragments])

    def vertex_array(
        self,
        layout: Sequence[tuple[moderngl.Buffer, str, *tuple[str, ...]]],
        index: moderngl.Buffer | None = None,
    ) -> moderngl.VertexArray:
        """Return what is drawn: buffers and the attributes they hold, without the unused ones."""
        return self._ctx.vertex_array(self._program, list(layout), index, skip_errors=True)

    def bind(
        self,
        *,
        textures: Mapping[str, Image] | None = None,
        uniforms: Mapping[str, object] | None = None,
        buffers: Mapping[str, moderngl.Buffer] | None = None,
    ) -> None:
        """Set what the next draw reads; raise ShaderError for a name that is not declared."""
        self._inputs.bind(textures, None, buffers, uniforms)

    def release(self) -> None:
        """Give the program back to OpenGL."""
        self._program.release()


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
    return groups_for(size[0], PIXEL_GROUP), groups_for(size[1], PIXEL_GROUP)


def groups_for(size: int, per_group: int) -> int:
    """Return how many groups of `per_group` cover `size`."""
    return -(-size // per_group)

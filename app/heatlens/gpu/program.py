"""A compute shader that is dispatched by name: every input is named in one call."""

from collections.abc import Mapping, Sequence

import moderngl

from heatlens.errors import ShaderError
from heatlens.gpu.shader_source import ShaderSource, assemble
from heatlens.gpu.uninterrupted import uninterrupted
from heatlens.paths import data_dir

Image = moderngl.Texture | moderngl.TextureArray | moderngl.Texture3D


class ComputeProgram:
    """One compiled compute shader.

    Samplers end in `_tx`, images in `_img`, storage blocks are `<name>_block`; units are given out
    once, when the program is built.
    """

    def __init__(
        self,
        ctx: moderngl.Context,
        name: str,
        defines: Mapping[str, object] | None = None,
        functions: str = "",
    ) -> None:
        """`functions` is GLSL made elsewhere: what the file declares and leaves undefined."""
        self.name = name
        self._ctx = ctx
        source = assemble(data_dir("shaders"), name, defines)
        self._program = _compile(ctx, source.followed_by(functions) if functions else source)
        names = list(self._program)
        self._units = _give_units(self._program, [n for n in names if n.endswith("_tx")])
        self._image_units = _give_units(self._program, [n for n in names if n.endswith("_img")])

    def dispatch(
        self,
        groups: tuple[int, int] | tuple[int, int, int],
        *,
        textures: Mapping[str, Image] | None = None,
        images: Mapping[str, Image] | None = None,
        buffers: Mapping[int, moderngl.Buffer] | None = None,
        uniforms: Mapping[str, object] | None = None,
    ) -> None:
        """Run on `groups` workgroups; names that the compiler removed as unused may be passed."""
        self._bind(textures, images, buffers, uniforms)
        self._program.run(*groups)
        self._ctx.memory_barrier()

    def dispatch_indirect(
        self,
        groups: moderngl.Buffer,
        *,
        offset: int = 0,
        textures: Mapping[str, Image] | None = None,
        images: Mapping[str, Image] | None = None,
        buffers: Mapping[int, moderngl.Buffer] | None = None,
        uniforms: Mapping[str, object] | None = None,
    ) -> None:
        """Run on as many workgroups as three words of `groups` say, `offset` bytes in."""
        self._bind(textures, images, buffers, uniforms)
        self._program.run_indirect(groups, offset)
        self._ctx.memory_barrier()

    def _bind(
        self,
        textures: Mapping[str, Image] | None,
        images: Mapping[str, Image] | None,
        buffers: Mapping[int, moderngl.Buffer] | None,
        uniforms: Mapping[str, object] | None,
    ) -> None:
        for name, texture in (textures or {}).items():
            if name in self._units:
                texture.use(self._units[name])
        for name, image in (images or {}).items():
            if name in self._image_units:
                image.bind_to_image(self._image_units[name])
        for binding, buffer in (buffers or {}).items():
            buffer.bind_to_storage_buffer(binding)
        for name, value in (uniforms or {}).items():
            if name in self._program:
                self._program[name] = value

    def release(self) -> None:
        """Give the program back to OpenGL."""
        self._program.release()


def _compile(ctx: moderngl.Context, source: ShaderSource) -> moderngl.ComputeShader:
    try:
        with uninterrupted():
            return ctx.compute_shader(source.text)
    except moderngl.Error as error:
        raise ShaderError(f"{source.files[0]}: {source.explained(str(error))}") from error


def _give_units(
    program: moderngl.ComputeShader | moderngl.Program, names: list[str]
) -> dict[str, int]:
    for unit, name in enumerate(names):
        program[name] = unit
    return {name: unit for unit, name in enumerate(names)}


def groups_for(size: int, per_group: int) -> int:
    """How many groups of `per_group` cover `size`."""
    return -(-size // per_group)


class DrawProgram:
    """`name`.vert.glsl and a .frag.glsl, with their inputs named in one call."""

    def __init__(
        self,
        ctx: moderngl.Context,
        name: str,
        fragment: str | None = None,
        defines: Mapping[str, object] | None = None,
    ) -> None:
        """`fragment` names the other shader where it is not called as the first is."""
        folder = data_dir("shaders")
        files = f"{name}.vert.glsl", f"{fragment or name}.frag.glsl"
        stages = [assemble(folder, file, defines) for file in files]
        self._ctx = ctx
        try:
            with uninterrupted():
                self._program = ctx.program(
                    vertex_shader=stages[0].text, fragment_shader=stages[1].text
                )
        except moderngl.Error as error:
            log = stages["fragment_shader" in str(error)].explained(str(error))
            raise ShaderError(f"{fragment or name}: {log}") from error
        samplers = [n for n in self._program if n.endswith("_tx")]
        self._units = _give_units(self._program, samplers)

    def vertex_array(
        self,
        layout: Sequence[tuple[moderngl.Buffer, str, *tuple[str, ...]]],
        index: moderngl.Buffer | None = None,
    ) -> moderngl.VertexArray:
        """What is drawn: buffers and the attributes they hold, those not used left out."""
        return self._ctx.vertex_array(self._program, list(layout), index, skip_errors=True)

    def bind(
        self,
        *,
        textures: Mapping[str, Image] | None = None,
        uniforms: Mapping[str, object] | None = None,
        buffers: Mapping[int, moderngl.Buffer] | None = None,
    ) -> None:
        """Set what the next draw reads; unused names may be passed all the same."""
        for name, texture in (textures or {}).items():
            if name in self._units:
                texture.use(self._units[name])
        for binding, buffer in (buffers or {}).items():
            buffer.bind_to_storage_buffer(binding)
        for name, value in (uniforms or {}).items():
            if name in self._program:
                self._program[name] = value

    def release(self) -> None:
        """Give the program back to OpenGL."""
        self._program.release()

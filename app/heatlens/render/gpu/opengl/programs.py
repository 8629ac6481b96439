"""Programs of OpenGL, which take all inputs by name, in one call."""

import os
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import moderngl

from heatlens.core.base.errors import ShaderError
from heatlens.core.base.stopping import delay_interrupts
from heatlens.render.gpu.framebuffer import Primitive
from heatlens.render.gpu.linked_program import (
    LinkedArray,
    LinkedCompute,
    LinkedDraw,
    LinkedProgram,
    NamedBuffers,
    NamedImages,
    Uniforms,
    VertexLayout,
)
from heatlens.render.gpu.opengl.objects import raw_buffer
from heatlens.render.gpu.resources import Buffer, BufferPart
from heatlens.render.gpu.shader_source import Kind, ShaderSource, declared_in

STRICT_VARIABLE = "HEATLENS_STRICT_SHADERS"

_WITH_UNITS: tuple[Kind, ...] = ("sampler", "image", "storage block")
# The types of image2DArray, iimage2DArray and uimage2DArray. moderngl 5.13 cannot set their unit,
# so that they must have the one that OpenGL gives them first, 0.
_IMAGE_ARRAYS = (0x9053, 0x905E, 0x9069)
_MODES = {
    Primitive.TRIANGLES: moderngl.TRIANGLES,
    Primitive.TRIANGLE_STRIP: moderngl.TRIANGLE_STRIP,
}
_NOTHING: Mapping[str, Any] = {}
Linked = moderngl.Program | moderngl.ComputeShader


class _GlProgram(LinkedProgram):
    """The inputs of a linked program, and the binding units of each.

    Samplers, images and storage blocks get their units here, once; binding numbers in the shader's
    text are ignored.
    """

    def __init__(self, raw: Linked, sources: Sequence[ShaderSource]) -> None:
        self.raw, self._names = raw, frozenset(raw)  # lookups in `raw` itself are slow
        self._declared = declared_in(sources)
        self._units: dict[str, int] = {}
        for kind in _WITH_UNITS:
            names = self._declared.of_kind(kind)
            self._assign_units(sorted((n for n in raw if n in names), key=self._is_settable))
        self._is_strict = bool(os.environ.get(STRICT_VARIABLE))
        # the uniforms that were never given a value
        self._unset = {n for n in raw if self._declared.kinds.get(n) == "uniform"}
        self._current_values: dict[
            str, object
        ] = {}  # the values that the uniforms of the program have

    def _is_settable(self, name: str) -> bool:
        """Return True if moderngl can set the unit of this input."""
        return getattr(self.raw[name], "gl_type", None) not in _IMAGE_ARRAYS

    def _assign_units(self, names: Iterable[str]) -> None:
        """Assign binding units 0, 1, .. to inputs of one kind. Raises ShaderError."""
        for unit, name in enumerate(names):
            member = self.raw[name]
            if isinstance(member, moderngl.StorageBlock):
                member.binding = unit
            elif self._is_settable(name):
                self.raw[name] = unit
            elif unit:
                raise ShaderError(f"{', '.join(self._declared.files)}: two arrays of images.")
            self._units[name] = unit

    def bind(
        self, textures: NamedImages, images: NamedImages, buffers: NamedBuffers, uniforms: Uniforms
    ) -> None:
        """Bind the inputs and outputs of the program's next run, by name.

        A name that is declared but not used has no unit and is left out. Raises ShaderError for a
        name that the program does not declare and, if strict, for one that is used but not given.
        """
        texture_map: Mapping[str, Any] = textures or _NOTHING
        image_map: Mapping[str, Any] = images or _NOTHING
        buffer_map: Mapping[str, Any] = buffers or _NOTHING
        for name, texture in texture_map.items():
            if (unit := self._unit_of(name, "sampler")) is not None:
                texture.use(unit)
        for name, image in image_map.items():
            if (unit := self._unit_of(name, "image")) is not None:
                image.bind_image(unit)
        for name, buffer in buffer_map.items():
            if (unit := self._unit_of(name, "storage block")) is not None:
                if isinstance(buffer, BufferPart):
                    whole: Any = buffer.whole
                    whole.bind_storage(unit, buffer.first, buffer.size)
                else:
                    buffer.bind_storage(unit)
        self._set(uniforms or _NOTHING)
        if self._is_strict:
            self._check_none_missing(texture_map.keys() | image_map.keys() | buffer_map.keys())

    def _unit_of(self, name: str, kind: Kind) -> int | None:
        """Return the unit of an input; None if the compiler removed it as unused."""
        unit = self._units.get(name)
        if unit is None or self._is_strict:
            self._declared.check(name, kind)
        return unit

    # Values that a program has already are not set again: checking and setting them took a quarter
    # of the time that Python spends on a pass.
    def _set(self, uniforms: Mapping[str, object]) -> None:
        """Set the uniforms whose values have changed."""
        for name, value in uniforms.items():
            if name in self._current_values and self._current_values[name] == value:
                continue
            self._declared.check(name, "uniform")
            if isinstance(value, int | float | tuple):  # others may be changed in place
                self._current_values[name] = value
            if name in self._names:
                self.raw[name] = value
                self._unset.discard(name)

    def _check_none_missing(self, bound: set[str]) -> None:
        """Check that every input with a unit is given, because all programs share the units."""
        missing = sorted((self._units.keys() - bound) | self._unset)
        if missing:
            names = ", ".join(missing)
            files = " and ".join(self._declared.files)
            raise ShaderError(f"{files}: declared and used, but never given: {names}.")

    def release(self) -> None:
        self.raw.release()


class GlCompute(_GlProgram, LinkedCompute):
    """A compute program of OpenGL."""

    def __init__(self, ctx: moderngl.Context, source: ShaderSource) -> None:
        raw = _compile(ctx, source)
        super().__init__(raw, [source])
        self._run, self._run_indirect, self._barrier = raw.run, raw.run_indirect, ctx.memory_barrier

    def run(self, groups: tuple[int, ...]) -> None:
        """Run on so many workgroups."""
        self._run(*groups)
        self._barrier()

    def run_indirect(self, groups: Buffer, offset: int) -> None:
        """Run on as many workgroups as the three words at `offset` say."""
        self._run_indirect(raw_buffer(groups), offset)
        self._barrier()


class GlDraw(_GlProgram, LinkedDraw):
    """A program of OpenGL that draws vertices."""

    def __init__(self, ctx: moderngl.Context, vertex: ShaderSource, fragment: ShaderSource) -> None:
        super().__init__(_link(ctx, vertex, fragment), [vertex, fragment])
        self._ctx = ctx

    def vertex_array(self, layout: VertexLayout, index: Buffer | None) -> LinkedArray:
        content = [(raw_buffer(buffer), *attributes) for buffer, *attributes in layout]
        indices = None if index is None else raw_buffer(index)
        return GlArray(self._ctx.vertex_array(self.raw, content, indices, skip_errors=True))


class GlArray(LinkedArray):
    """A vertex array of OpenGL."""

    def __init__(self, raw: moderngl.VertexArray) -> None:
        self._raw = raw

    def render(self, mode: Primitive, vertices: int) -> None:
        """Draw so many vertices."""
        self._raw.render(_MODES[mode], vertices)

    def render_indirect(self, commands: Buffer, mode: Primitive, count: int) -> None:
        self._raw.render_indirect(raw_buffer(commands), _MODES[mode], count)

    def release(self) -> None:
        self._raw.release()


def _compile(ctx: moderngl.Context, source: ShaderSource) -> moderngl.ComputeShader:
    """Compile a compute shader. Raises ShaderError with the driver's log."""
    try:
        with delay_interrupts():
            return ctx.compute_shader(source.text)
    except moderngl.Error as error:
        raise ShaderError(f"{source.files[0]}: {source.explain_log(str(error))}") from error


def _link(ctx: moderngl.Context, vertex: ShaderSource, fragment: ShaderSource) -> moderngl.Program:
    """Compile and link two stages. Raises ShaderError with the driver's log."""
    try:
        with delay_interrupts():
            return ctx.program(vertex_shader=vertex.text, fragment_shader=fragment.text)
    except moderngl.Error as error:
        stage = fragment if "fragment_shader" in str(error) else vertex
        raise ShaderError(f"{stage.files[0]}: {stage.explain_log(str(error))}") from error

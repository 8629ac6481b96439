"""Read from SPIR-V what a program takes: its bindings, its block of uniforms, its vertex inputs.

The numbers of operations and decorations are those of the SPIR-V specification, version 1.0.
"""

import struct
from collections import defaultdict
from dataclasses import dataclass, field
from enum import IntEnum
from typing import Literal

import numpy as np

from heatlens.render.gpu.wgpu.translation import SAMPLER, TEXTURE

Kind = Literal["texture", "sampler", "image", "storage", "uniforms"]

_HEADER_WORDS = 5


class _Op(IntEnum):
    NAME = 5
    MEMBER_NAME = 6
    TYPE_INT = 21
    TYPE_FLOAT = 22
    TYPE_VECTOR = 23
    TYPE_MATRIX = 24
    TYPE_IMAGE = 25
    TYPE_SAMPLER = 26
    TYPE_ARRAY = 28
    TYPE_STRUCT = 30
    TYPE_POINTER = 32
    CONSTANT = 43
    VARIABLE = 59
    DECORATE = 71
    MEMBER_DECORATE = 72


_FUNCTION, _NOTED = 54, frozenset(map(int, _Op))


class _Decoration(IntEnum):
    BUFFER_BLOCK = 3
    ARRAY_STRIDE = 6
    MATRIX_STRIDE = 7
    BUILT_IN = 11
    NON_WRITABLE = 24
    NON_READABLE = 25
    LOCATION = 30
    BINDING = 33
    OFFSET = 35


_INPUT_CLASS = 1
_SHAPES = {(1, 0): "2d", (1, 1): "2d-array", (2, 0): "3d"}  # dimension and arrayed
# Names of formats: of SPIR-V by number, in GLSL and in wgpu.
_FORMAT_NAMES = {
    1: "rgba32float",
    2: "rgba16float",
    3: "r32float",
    4: "rgba8unorm",
    6: "rg32float",
    7: "rg16float",
    9: "r16float",
    30: "rgba32uint",
    33: "r32uint",
    35: "rg32uint",
}


@dataclass(frozen=True)
class Binding:
    """One resource of a program.

    number  of the binding
    kind    what is bound
    name    as the shader declares it, of a texture and its sampler the same
    layout  what wgpu's layout of a bind group says of it
    """

    number: int
    kind: Kind
    name: str
    layout: dict[str, object]


@dataclass(frozen=True)
class Uniform:
    """Where a uniform lies in its block: `count` elements of `columns` by `rows` numbers."""

    offset: int
    dtype: str
    rows: int = 1
    columns: int = 1
    column_bytes: int = 16
    count: int = 1
    element_bytes: int = 0

    def write(self, block: bytearray, value: object) -> None:
        """Put a value into the block, in the order in which OpenGL takes it."""
        data = np.frombuffer(value, self.dtype) if isinstance(value, bytes) else np.asarray(value)
        numbers = data.astype(self.dtype).reshape(-1, self.columns, self.rows)
        for index, element in enumerate(numbers[: self.count]):
            for column, row in enumerate(element):
                at = self.offset + index * self.element_bytes + column * self.column_bytes
                block[at : at + row.nbytes] = row.tobytes()


@dataclass
class Reflection:
    """What a stage takes: its resources, its uniforms by name, and its vertex inputs' locations."""

    bindings: list[Binding] = field(default_factory=list)
    uniforms: dict[str, Uniform] = field(default_factory=dict)
    block_bytes: int = 0
    inputs: dict[str, int] = field(default_factory=dict)


def reflect(module: bytes) -> Reflection:
    """Return what a stage takes."""
    return _Module(module).reflection()


class _Module:
    """The names, types and decorations of a module, by their numbers."""

    def __init__(self, module: bytes) -> None:
        self.names: dict[int, tuple[int, ...]] = {}  # the words of each, most of which nobody reads
        self.member_names: dict[tuple[int, int], tuple[int, ...]] = {}
        self.decorations: dict[tuple[int, int], dict[int, int]] = defaultdict(dict)
        self.types: dict[int, tuple[int, tuple[int, ...]]] = {}
        self.constants: dict[int, int] = {}
        self.variables: list[tuple[int, int, int]] = []  # number, type of the pointer, class
        words = struct.unpack(f"<{len(module) // 4}I", module)
        at = _HEADER_WORDS
        while (op := words[at] & 0xFFFF) != _FUNCTION:  # all that is declared comes before
            count = words[at] >> 16
            if op in _NOTED:
                self._note(op, words[at + 1 : at + count])
            at += count

    def _note(self, op: int, words: tuple[int, ...]) -> None:
        """Keep one instruction, if it is one of those that tell what is taken."""
        if op == _Op.NAME:
            self.names[words[0]] = words[1:]
        elif op == _Op.MEMBER_NAME:
            self.member_names[words[0], words[1]] = words[2:]
        elif op == _Op.DECORATE:
            self.decorations[words[0], -1][words[1]] = words[2] if len(words) > 2 else 1
        elif op == _Op.MEMBER_DECORATE:
            self.decorations[words[0], words[1]][words[2]] = words[3] if len(words) > 3 else 1
        elif _Op.TYPE_INT <= op <= _Op.TYPE_POINTER:
            self.types[words[0]] = op, words[1:]
        elif op == _Op.CONSTANT:
            self.constants[words[1]] = words[2]
        elif op == _Op.VARIABLE:
            self.variables.append((words[1], words[0], words[2]))

    def reflection(self) -> Reflection:
        """Return what the module takes."""
        found = Reflection()
        for number, pointer, storage_class in self.variables:
            decorations = self.decorations[number, -1]
            if _Decoration.BINDING in decorations:
                found.bindings.append(self._binding(number, self.types[pointer][1][1], found))
            elif storage_class == _INPUT_CLASS and _Decoration.LOCATION in decorations:
                found.inputs[_text(self.names[number])] = decorations[_Decoration.LOCATION]
        return found

    def _binding(self, variable: int, type_: int, found: Reflection) -> Binding:
        """Return one resource; the block of uniforms also fills in `found`."""
        number = self.decorations[variable, -1][_Decoration.BINDING]
        op, words = self.types[type_]
        name = _text(self.names[variable]) or _text(self.names[type_])
        layout: dict[str, object]
        if op == _Op.TYPE_SAMPLER:
            return Binding(number, "sampler", name.removesuffix(SAMPLER), {"type": "filtering"})
        if op == _Op.TYPE_IMAGE:
            return self._image(variable, number, name, words)
        if _Decoration.BUFFER_BLOCK in self.decorations[type_, -1]:
            is_read = _Decoration.NON_WRITABLE in self.decorations[type_, 0]
            layout = {"type": "read-only-storage" if is_read else "storage"}
            return Binding(number, "storage", _text(self.names[type_]), layout)
        for index, member in enumerate(words):
            uniform = self._uniform(type_, index, member)
            found.uniforms[_text(self.member_names[type_, index])] = uniform
            found.block_bytes = max(found.block_bytes, _end(uniform))
        layout = {"type": "uniform", "has_dynamic_offset": True}
        return Binding(number, "uniforms", name, layout)

    def _image(self, variable: int, number: int, name: str, words: tuple[int, ...]) -> Binding:
        """Return a texture that is sampled, or an image that is read and written."""
        sampled_type, dimension, _, is_array, _, sampled, format_ = words[:7]
        shape = _SHAPES[dimension, is_array]
        if sampled == 1:
            op, signs = self.types[sampled_type]
            numbers = "float" if op == _Op.TYPE_FLOAT else "sint" if signs[1] else "uint"
            layout: dict[str, object] = {"sample_type": numbers, "view_dimension": shape}
            return Binding(number, "texture", name.removesuffix(TEXTURE), layout)
        decorations = self.decorations[variable, -1]
        access = "read-write"
        if _Decoration.NON_READABLE in decorations:
            access = "write-only"
        elif _Decoration.NON_WRITABLE in decorations:
            access = "read-only"
        layout = {"access": access, "format": _FORMAT_NAMES[format_], "view_dimension": shape}
        return Binding(number, "image", name, layout)

    def _uniform(self, block: int, index: int, type_: int) -> Uniform:
        """Return where a member of a block of uniforms lies."""
        decorations = self.decorations[block, index]
        offset, count, element_bytes = decorations[_Decoration.OFFSET], 1, 0
        op, words = self.types[type_]
        if op == _Op.TYPE_ARRAY:
            count = self.constants[words[1]]
            element_bytes = self.decorations[type_, -1][_Decoration.ARRAY_STRIDE]
            op, words = self.types[words[0]]
        columns, rows = 1, 1
        if op == _Op.TYPE_MATRIX:
            columns = words[1]
            op, words = self.types[words[0]]
        if op == _Op.TYPE_VECTOR:
            rows = words[1]
            op, words = self.types[words[0]]
        dtype = "<f4" if op == _Op.TYPE_FLOAT else "<i4" if words[1] else "<u4"
        column_bytes = decorations.get(_Decoration.MATRIX_STRIDE, 4 * rows)
        return Uniform(offset, dtype, rows, columns, column_bytes, count, element_bytes)


def _end(uniform: Uniform) -> int:
    """Return the first byte after a uniform, rounded up as the alignment of blocks asks."""
    last = (uniform.count - 1) * uniform.element_bytes + uniform.columns * max(
        uniform.column_bytes, 4 * uniform.rows
    )
    return -(-(uniform.offset + last) // 16) * 16


def _text(words: tuple[int, ...]) -> str:
    """Return the text that is packed into words and ends with a zero byte."""
    return struct.pack(f"<{len(words)}I", *words).partition(b"\0")[0].decode()

"""Assemble GLSL from shader files: `#include "lib/x.lib.glsl"`, defines, and error positions.

`#include NAME` without quotes includes the file that the define NAME gives.

Each file gets its own range of line numbers through `#line`, because Mesa reports line numbers
correctly but not file numbers. This handles only text, and is testable without OpenGL.

The inputs that a text declares are found, so that a misspelt name is an error. OpenGL itself cannot
distinguish a misspelt name from one that the compiler removed as unused: both are missing from the
linked program. Declarations inside any `#if` are included, so that all builds of a shader accept
the same names.
"""

import os
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from functools import lru_cache
from pathlib import Path
from typing import Literal

from heatlens.core.base.errors import ShaderError
from heatlens.render.gpu.shader_constants import constants_in

LINES_PER_FILE = 10_000  # line 20_014 of the assembled text is line 14 of the third file
_INCLUDE = re.compile(r'^\s*#include\s+(?:"([^"]+)"|(\w+))\s*(?://.*)?$')
_LINE_IN_LOG = re.compile(r"\b\d+(?::(\d+)|\((\d+)\))")
Stage = Literal["comp", "vert", "frag"]
Kind = Literal["sampler", "image", "storage block", "uniform"]

_COMMENT = re.compile(r"//[^\n]*|/\*.*?\*/", re.S)
_DIRECTIVE = re.compile(r"^[ \t]*#[^\n]*$", re.M)
_UNIFORM = re.compile(r"\buniform\s+([^;{}]+);")
_WORD = re.compile(r"\b[A-Z][A-Z0-9_]+\b")
_BLOCK = re.compile(r"\bbuffer\s+(\w+)\s*\{")
_ARRAY_SIZE = re.compile(r"\[[^\]]*\]")


@dataclass(frozen=True)
class ShaderSource:
    """The assembled text, the files it came from in the order of their line ranges, and its inputs.

    `kinds` has the kind of each input that is declared.
    """

    text: str
    files: tuple[str, ...]
    kinds: Mapping[str, Kind]

    def explain_log(self, log: str) -> str:
        """Return the driver's log with positions as `file:line`."""

        def position_text(match: re.Match[str]) -> str:
            index, line = divmod(int(match[1] or match[2]), LINES_PER_FILE)
            return f"{self.files[index]}:{line}" if index < len(self.files) else match[0]

        return _LINE_IN_LOG.sub(position_text, log)

    def append_functions(self, functions: str) -> "ShaderSource":
        """Append generated GLSL, in its own range of line numbers."""
        line = len(self.files) * LINES_PER_FILE + 1
        text = f"{self.text}#line {line}\n{functions}\n"
        kinds = {**self.kinds, **kinds_in(functions)}
        return ShaderSource(text, (*self.files, "generated GLSL"), kinds)


# The text of a build is the same at every start, because the driver's cache of compiled shaders
# compares texts. With the constants in the order of a set, which follows Python's hash seed, the
# second render after a fresh cache took 4.0 s; it takes 1.3 s now.
def assemble(folder: Path, name: str, defines: Mapping[str, object] | None = None) -> ShaderSource:
    """Return the shader `name` of `folder`, its includes in place (each once), `defines` on top.

    The order of `defines` does not matter. The constants of `gpu.shader_constants` that it mentions
    are defined too.
    """
    all_defines = dict(sorted((defines or {}).items()))
    files: dict[str, _ShaderFile] = {}
    body = _expand(folder, name, all_defines, files)
    words = frozenset[str]().union(*(file.words for file in files.values()))
    constants = {
        name: text for name, text in constants_in(words).items() if name not in all_defines
    }
    head = "".join(f"#define {key} {value}\n" for key, value in (all_defines | constants).items())
    kinds = {name: kind for file in files.values() for name, kind in file.kinds.items()}
    return ShaderSource(text=f"#version 430 core\n{head}{body}", files=tuple(files), kinds=kinds)


def _expand(
    folder: Path, name: str, defines: Mapping[str, object], files: dict[str, "_ShaderFile"]
) -> str:
    """Return the text of a file with its includes in place.

    Each file is added to `files`, and is included only once.
    """
    base = len(files) * LINES_PER_FILE
    file = files[name] = _read_file(folder, name)
    parts = [f"#line {base + 1}\n"]
    for piece in file.pieces:
        parts.append(piece.text)
        include = str(defines.get(piece.include, piece.include))
        if include and include not in files:
            parts.append(_expand(folder, include, defines, files))
        parts.append(f"#line {base + piece.end + 1}\n" if include else "")
    return "".join(parts)


@dataclass(frozen=True)
class _Piece:
    """The lines of a file before an include, or after the last one.

    text     the lines
    end      number of the line with the include, or of the last line
    include  the file that is included, or a define that names it; "" for none
    """

    text: str
    end: int
    include: str


@dataclass(frozen=True)
class _ShaderFile:
    """A file: its text between includes, its words in capitals, and its declared inputs."""

    pieces: tuple[_Piece, ...]
    words: frozenset[str]
    kinds: Mapping[str, Kind]


def _read_file(folder: Path, name: str) -> _ShaderFile:
    """Return a shader file, parsed again only if it has changed."""
    path = os.path.join(folder, name)  # faster than pathlib, for hundreds of files
    try:
        status = os.stat(path)
    except OSError:
        raise ShaderError(f"{name}: no such shader in {folder}") from None
    return _parse_file(path, (status.st_mtime_ns, status.st_size))


@lru_cache(maxsize=512)  # more than there are; many are parts of dozens of shaders
def _parse_file(path: str, _state: tuple[int, int]) -> _ShaderFile:
    """Return the parts of a file; `_state` changes when it is edited."""
    text = Path(path).read_text(encoding="utf-8")
    return _ShaderFile(
        pieces=tuple(_split_at_includes(text)),
        words=frozenset(_WORD.findall(text)),
        kinds=kinds_in(text),
    )


def _split_at_includes(text: str) -> Iterator[_Piece]:
    """Yield the lines before each include, and those after the last one."""
    lines: list[str] = []
    end = 0
    for end, line in enumerate(text.splitlines(), start=1):
        if match := _INCLUDE.match(line):
            yield _Piece("".join(lines), end, match[1] or match[2])
            lines.clear()
        else:
            lines.append(f"{line}\n")
    yield _Piece("".join(lines), end, "")


@dataclass(frozen=True)
class DeclaredInputs:
    """The inputs that a program built from `files` declares: the kind of each name."""

    files: tuple[str, ...]
    kinds: Mapping[str, Kind]

    def check(self, name: str, kind: Kind) -> None:
        """Raise a ShaderError with the nearest declared name unless `name` is of that `kind`."""
        if self.kinds.get(name) != kind:
            raise ShaderError(self._describe_mistake(name, kind))

    def of_kind(self, kind: Kind) -> set[str]:
        """Return the names of one kind."""
        return {name for name, declared in self.kinds.items() if declared == kind}

    def _describe_mistake(self, name: str, kind: Kind) -> str:
        """Return the message for an input that is not declared, or not as this kind."""
        files = " and ".join(self.files)
        if name in self.kinds:
            return f"{files}: '{name}' is declared as a {self.kinds[name]}, not as a {kind}."
        near = get_close_matches(name, sorted(self.of_kind(kind)), 1, 0.0)
        hint = f"Did you mean '{near[0]}'?" if near else "None is declared."
        return f"{files}: no {kind} '{name}' is declared. {hint}"


def declared_in(sources: Sequence[ShaderSource]) -> DeclaredInputs:
    """Return the inputs that the stages of a program declare together."""
    kinds = {name: kind for source in sources for name, kind in source.kinds.items()}
    return DeclaredInputs(tuple(source.files[0] for source in sources), kinds)


def kinds_in(text: str) -> dict[str, Kind]:
    """Return the inputs that a text declares, each with its kind."""
    bare = _DIRECTIVE.sub("", _COMMENT.sub("", text.replace("\\\n", " ")))
    kinds: dict[str, Kind] = {}
    for match in _UNIFORM.finditer(bare):
        kinds |= _kinds_of(match[1])
    return kinds | dict.fromkeys(_BLOCK.findall(bare), "storage block")


def _kinds_of(declaration: str) -> dict[str, Kind]:
    """Return the names of `vec2 a, b[4]`, each with the kind of its type."""
    first, *other_names = _ARRAY_SIZE.sub("", declaration).split(",")
    *words, name = first.split()
    kind: Kind = "uniform"
    if any("sampler" in word for word in words):
        kind = "sampler"
    elif any(re.match(r"[iu]?image\d", word) for word in words):
        kind = "image"
    return dict.fromkeys([name, *(part.strip() for part in other_names)], kind)

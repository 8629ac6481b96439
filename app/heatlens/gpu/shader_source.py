"""Assemble GLSL from shader files: `#include "lib/x.lib.glsl"`, defines, and error positions.

`#include NAME` without quotes includes the file that the define NAME gives.

Each file gets its own range of line numbers through `#line`, because Mesa reports line numbers
correctly but not file numbers. This handles only text, and is testable without OpenGL.

The inputs that a text declares are found, so that a misspelt name is an error. OpenGL itself cannot
distinguish a misspelt name from one that the compiler removed as unused: both are missing from the
linked program. Declarations inside any `#if` are included, so that all builds of a shader accept
the same names.
"""

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from difflib import get_close_matches
from pathlib import Path
from typing import Literal

from heatlens.base.errors import ShaderError
from heatlens.gpu.shader_constants import constants_in

LINES_PER_FILE = 10_000  # line 20_014 of the assembled text is line 14 of the third file
_INCLUDE = re.compile(r'^\s*#include\s+(?:"([^"]+)"|(\w+))\s*$')
_LINE_IN_LOG = re.compile(r"\b\d+(?::(\d+)|\((\d+)\))")
Kind = Literal["sampler", "image", "storage block", "uniform"]

_COMMENT = re.compile(r"//[^\n]*|/\*.*?\*/", re.S)
_DIRECTIVE = re.compile(r"^[ \t]*#[^\n]*$", re.M)
_UNIFORM = re.compile(r"\buniform\s+([^;{}]+);")
_BLOCK = re.compile(r"\bbuffer\s+(\w+)\s*\{")
_ARRAY_SIZE = re.compile(r"\[[^\]]*\]")


@dataclass(frozen=True)
class ShaderSource:
    """The assembled text and the files it came from, in the order of their line ranges."""

    text: str
    files: tuple[str, ...]

    def explained(self, log: str) -> str:
        """Return the driver's log with places as `file:line`."""

        def place(match: re.Match[str]) -> str:
            index, line = divmod(int(match[1] or match[2]), LINES_PER_FILE)
            return f"{self.files[index]}:{line}" if index < len(self.files) else match[0]

        return _LINE_IN_LOG.sub(place, log)

    def followed_by(self, functions: str) -> "ShaderSource":
        """Append generated GLSL, in its own range of line numbers."""
        line = len(self.files) * LINES_PER_FILE + 1
        text = f"{self.text}#line {line}\n{functions}\n"
        return ShaderSource(text, (*self.files, "generated GLSL"))


def assemble(folder: Path, name: str, defines: Mapping[str, object] | None = None) -> ShaderSource:
    """Return the shader `name` of `folder`, its includes in place (each once), `defines` on top.

    The constants of `gpu.shader_constants` that it mentions are defined too.
    """
    given = dict(defines or {})
    files: list[str] = []
    body = _expand(folder, name, given, files)
    known = {name: text for name, text in constants_in(body).items() if name not in given}
    head = "".join(f"#define {key} {value}\n" for key, value in (given | known).items())
    return ShaderSource(f"#version 430 core\n{head}{body}", tuple(files))


def _expand(folder: Path, name: str, defines: Mapping[str, object], files: list[str]) -> str:
    base = len(files) * LINES_PER_FILE
    files.append(name)
    path = folder / name
    if not path.is_file():
        raise ShaderError(f"{name}: no such shader in {folder}")
    lines = [f"#line {base + 1}"]
    for number, line in enumerate(path.read_text().splitlines(), start=1):
        match = _INCLUDE.match(line)
        if match is None:
            lines.append(line)
            continue
        include = match[1] or str(defines.get(match[2], match[2]))
        if include not in files:
            lines += [_expand(folder, include, defines, files), f"#line {base + number + 1}"]
    return "\n".join(lines) + "\n"


@dataclass(frozen=True)
class DeclaredInputs:
    """The inputs that a program built from `files` declares: the kind of each name."""

    files: tuple[str, ...]
    kinds: Mapping[str, Kind]

    def check(self, name: str, kind: Kind) -> None:
        """Raise a ShaderError with the nearest declared name unless `name` is of that `kind`."""
        if self.kinds.get(name) != kind:
            raise ShaderError(self._explained(name, kind))

    def of_kind(self, kind: Kind) -> set[str]:
        """Return the names of one kind."""
        return {name for name, declared in self.kinds.items() if declared == kind}

    def _explained(self, name: str, kind: Kind) -> str:
        files = " and ".join(self.files)
        if name in self.kinds:
            return f"{files}: '{name}' is declared as a {self.kinds[name]}, not as a {kind}."
        near = get_close_matches(name, sorted(self.of_kind(kind)), 1, 0.0)
        hint = f"Did you mean '{near[0]}'?" if near else "None is declared."
        return f"{files}: no {kind} '{name}' is declared. {hint}"


def declared_in(files: Iterable[str], texts: Iterable[str]) -> DeclaredInputs:
    """Read the declarations from the assembled `texts` of the shaders called `files`."""
    kinds: dict[str, Kind] = {}
    for text in texts:
        bare = _DIRECTIVE.sub("", _COMMENT.sub("", text.replace("\\\n", " ")))
        for match in _UNIFORM.finditer(bare):
            kinds |= _kinds_of(match[1])
        kinds |= dict.fromkeys(_BLOCK.findall(bare), "storage block")
    return DeclaredInputs(tuple(files), kinds)


def _kinds_of(declaration: str) -> dict[str, Kind]:
    """Return the names of `vec2 a, b[4]`, each with the kind of its type."""
    first, *more = _ARRAY_SIZE.sub("", declaration).split(",")
    *words, name = first.split()
    kind: Kind = "uniform"
    if any("sampler" in word for word in words):
        kind = "sampler"
    elif any(re.match(r"[iu]?image\d", word) for word in words):
        kind = "image"
    return dict.fromkeys([name, *(part.strip() for part in more)], kind)

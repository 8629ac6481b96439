"""Assemble GLSL from shader files: `#include "lib/x.lib.glsl"`, defines, and error positions.

`#include NAME` without quotes includes the file that the define NAME gives.

Each file gets its own range of line numbers through `#line`, because Mesa reports line numbers
correctly but not file numbers. This handles only text, and is testable without OpenGL.
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from heatlens.base.errors import ShaderError
from heatlens.gpu.shader_constants import constants_in

LINES_PER_FILE = 10_000  # line 20_014 of the assembled text is line 14 of the third file
_INCLUDE = re.compile(r'^\s*#include\s+(?:"([^"]+)"|(\w+))\s*$')
_LINE_IN_LOG = re.compile(r"\b\d+([:(])(\d+)")


@dataclass(frozen=True)
class ShaderSource:
    """The assembled text and the files it came from, in the order of their line ranges."""

    text: str
    files: tuple[str, ...]

    def explained(self, log: str) -> str:
        """Return the driver's log with places as `file:line`."""

        def place(match: re.Match[str]) -> str:
            index, line = divmod(int(match[2]), LINES_PER_FILE)
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

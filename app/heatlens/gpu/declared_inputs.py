"""Find the inputs that a shader's text declares, so that a misspelt name is an error.

OpenGL itself cannot distinguish a misspelt name from one that the compiler removed as unused: both
are missing from the linked program. Declarations inside any `#if` are included, so that all builds
of a shader accept the same names. This handles only text, and is testable without OpenGL.
"""

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from difflib import get_close_matches
from typing import Literal

from heatlens.base.errors import ShaderError

Kind = Literal["sampler", "image", "storage block", "uniform"]

_COMMENT = re.compile(r"//[^\n]*|/\*.*?\*/", re.S)
_DIRECTIVE = re.compile(r"^[ \t]*#[^\n]*$", re.M)
_UNIFORM = re.compile(r"\buniform\s+([^;{}]+);")
_BLOCK = re.compile(r"\bbuffer\s+(\w+)\s*\{")
_ARRAY_SIZE = re.compile(r"\[[^\]]*\]")


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

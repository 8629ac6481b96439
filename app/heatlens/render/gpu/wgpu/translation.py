"""Translate the stages of a program from the GLSL of OpenGL to that of Vulkan.

The shaders are one text for both devices. What differs is changed here, in the text:

- A sampler of OpenGL is a texture and a sampler in one; wgpu has them apart. Each declaration
  becomes two, and a macro of the old name joins them where the shader uses them.
- An image that is only written may have any format in OpenGL; in wgpu every image has one.
- Every input has a binding of its own; binding 0 is the block of loose uniforms, which the compiler
  makes (`spirv.py`).
- Storage blocks lose `writeonly` and the like, which naga, the translator of wgpu, refuses.
- OpenGL's clip space has y upwards from row 0, and depths from -1 to 1.
"""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from heatlens.render.gpu.shader_source import ShaderSource, Stage

TEXTURE, SAMPLER = "_texture", "_sampler"  # endings of the two names that a sampler of OpenGL gets

# Python finds patterns that begin with plain letters 30 times as fast as others.
_SAMPLER = re.compile(r"uniform\s+([iu]?)sampler(2D|2DArray|3D)(Shadow|)\s+([^;]+);")
_IMAGE = re.compile(
    r"^(?:layout\((\w+)\) )?((?:[a-z]+ )*?uniform [\w ]*?[iu]?image2D\w*\s+)(\w+)\s*;", re.M
)
_ACCESS = re.compile(r"\b(?:writeonly|restrict|coherent)\s+")
_BUFFER = re.compile(r"^layout\(std430\) (.*\bbuffer\s+(\w+)\s*\{)", re.M)
_EARLY = re.compile(r"layout\s*\(\s*early_fragment_tests\s*\)\s*in\s*;")
_VARYING = {
    "vert": re.compile(r"^((?:flat |centroid )?out \w+ (\w+);)", re.M),
    "frag": re.compile(r"^((?:flat |centroid )?in \w+ (\w+);)", re.M),
}
_MAIN = re.compile(r"\bvoid\s+main\s*\(\s*\)")
_CLIP_SPACE = """
void main() {
    main_of_opengl();
    gl_Position.y = -gl_Position.y;
    gl_Position.z = 0.5 * (gl_Position.z + gl_Position.w);
}
"""


@dataclass(frozen=True)
class StageText:
    """One stage of a program, in GLSL for Vulkan."""

    stage: Stage
    text: str


def translate_stages(
    sources: Mapping[Stage, ShaderSource], formats: Mapping[str, str]
) -> list[StageText]:
    """Return the stages of a program; `formats` are those of images that declare none."""
    translation = _Translation(sources, formats)
    return [StageText(stage, translation.text_of(stage)) for stage in sources]


def formatless_images(source: ShaderSource) -> list[str]:
    """Return the names of the images that declare no format."""
    return [match[3] for match in _IMAGE.finditer(source.text) if match[1] is None]


def comparing_samplers(sources: Sequence[ShaderSource]) -> set[str]:
    """Return the names of the samplers that compare depths."""
    found = (match for source in sources for match in _SAMPLER.finditer(source.text))
    return {name.strip() for match in found if match[3] for name in match[4].split(",")}


class _Translation:
    """The translation of one program: which bindings and locations are taken."""

    def __init__(self, sources: Mapping[Stage, ShaderSource], formats: Mapping[str, str]) -> None:
        self._sources, self._formats = sources, formats
        self._bindings: dict[str, int] = {}  # by name: what both stages have is one binding
        vertex = sources["vert"].text if "vert" in sources else ""
        names = dict.fromkeys(match[2] for match in _VARYING["vert"].finditer(vertex))
        # of what vertices hand to fragments
        self._locations = {name: number for number, name in enumerate(names)}

    def text_of(self, stage: Stage) -> str:
        """Return the text of a stage."""
        _, _, body = self._sources[stage].text.partition("\n")  # the first line is the version
        body = _BUFFER.sub(self._buffer, _IMAGE.sub(self._image, _SAMPLER.sub(self._sampler, body)))
        body = _EARLY.sub("", body)  # devices test early by themselves where nothing forbids it
        if stage in _VARYING:
            body = _VARYING[stage].sub(self._varying, body)
        if stage == "vert":
            body = _MAIN.sub("void main_of_opengl()", body) + _CLIP_SPACE
        return f"#version 430\n{body}"

    def _sampler(self, match: re.Match[str]) -> str:
        """Return declarations of a texture and a sampler, and the macro that joins them."""
        number, shape, shadow, names = match.groups()
        lines = []
        for name in (word.strip() for word in names.split(",")):
            lines += [
                f"{self._layout(name + TEXTURE)} uniform {number}texture{shape} {name}{TEXTURE};",
                f"{self._layout(name + SAMPLER)} uniform sampler{shadow} {name}{SAMPLER};",
                f"#define {name} {number}sampler{shape}{shadow}({name}{TEXTURE}, {name}{SAMPLER})",
            ]
        return "\n".join([*lines, ""])

    def _image(self, match: re.Match[str]) -> str:
        """Return the declaration of an image with its format and binding."""
        format_ = match[1] or self._formats[match[3]]
        return f"{self._layout(match[3], format_)} {match[2]}{match[3]};"

    def _buffer(self, match: re.Match[str]) -> str:
        """Return the head of a storage block with its binding."""
        return f"{self._layout(match[2], 'std430')} {_ACCESS.sub('', match[1])}"

    def _layout(self, name: str, *words: str) -> str:
        """Return the layout of an input, with its binding."""
        number = self._bindings.setdefault(name, len(self._bindings) + 1)
        return f"layout({', '.join([*words, f'binding = {number}'])})"

    def _varying(self, match: re.Match[str]) -> str:
        """Return the declaration of what vertices hand to fragments, with its location."""
        return f"layout(location = {self._locations[match[2]]}) {match[1]}"

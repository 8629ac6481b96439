"""The vertices of a draw: buffers, and the attributes in them by name."""

import re
from collections.abc import Mapping
from typing import Any

from heatlens.render.gpu.linked_program import VertexLayout

_ITEM = re.compile(r"(\d+)([fui])([124]?)")
_NAMES = {"f": "float", "u": "uint", "i": "sint"}


class VertexInputs:
    """Buffers and their layouts as wgpu takes them.

    The formats are those of moderngl, such as "3f 4f2/i": three floats and four half floats of each
    instance.
    """

    def __init__(self, layout: VertexLayout, locations: Mapping[str, int]) -> None:
        self.buffers = [buffer for buffer, *_ in layout]
        self.layouts = [_layout(*rest, locations=locations) for _, *rest in layout]
        self.key = str(self.layouts)
        self.instances = 1


def _layout(format_: str, *names: str, locations: Mapping[str, int]) -> dict[str, Any]:
    """Return the layout of one buffer, without the attributes that have no location."""
    items, _, step = format_.partition("/")
    attributes, offset = [], 0
    for item, name in zip(items.split(), names, strict=True):
        match = _ITEM.fullmatch(item)
        assert match, item
        count, letter, size = int(match[1]), match[2], int(match[3] or 4)
        if name in locations:
            suffix = f"x{count}" if count > 1 else ""
            attributes.append(
                {
                    "format": f"{_NAMES[letter]}{8 * size}{suffix}",
                    "offset": offset,
                    "shader_location": locations[name],
                }
            )
        offset += count * size
    mode = "instance" if step == "i" else "vertex"
    return {"array_stride": offset, "step_mode": mode, "attributes": attributes}

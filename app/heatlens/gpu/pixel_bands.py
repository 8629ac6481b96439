"""Run programs on the pixels of a picture in bands, so that a window can answer in between."""

from collections.abc import Iterator
from typing import Any

import moderngl

from heatlens.gpu.context import is_software
from heatlens.gpu.program import ComputeProgram, groups_for
from heatlens.gpu.shader_constants import PIXEL_GROUP

BAND_PX = 1 << 18  # some ten milliseconds on two busy cores


class PixelBands:
    """Cuts pictures into bands of rows on a processor; a GPU gets them whole."""

    def __init__(self, ctx: moderngl.Context) -> None:
        self._is_cut = is_software(ctx)

    def run(
        self,
        program: ComputeProgram,
        size: tuple[int, int],
        uniforms: dict[str, object] | None = None,
        side: int = 1,
        group: int = PIXEL_GROUP,
        **inputs: Any,
    ) -> Iterator[None]:
        """Run on a picture of `size` invocations, and yield after each band.

        Each invocation has `side` x `side` pixels of the plate, and each workgroup `group` x
        `group` invocations. The shader adds the uniform `first_row` to the row of an invocation.
        """
        width, height = size
        most = BAND_PX // (width * side * side) // group * group
        rows = max(group, most) if self._is_cut else height
        for first_row in range(0, height, rows):
            groups = groups_for(width, group), groups_for(min(rows, height - first_row), group)
            uniforms = {**(uniforms or {}), "first_row": first_row}
            program.dispatch(groups, uniforms=uniforms, **inputs)
            yield

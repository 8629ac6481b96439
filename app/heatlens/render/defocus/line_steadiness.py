"""Find how steady the rows and columns of a layer are, for the guess behind wide things."""

import math
from collections.abc import Iterator
from dataclasses import dataclass

from heatlens.render.defocus.line_solver import Axis, Bindings, LineSolver, LineSystem
from heatlens.render.gpu.program import groups_for
from heatlens.render.gpu.resources import StorageBuffer, Texture
from heatlens.render.gpu.shader_constants import LINE_NODE

_LINE_STEPS = 107  # steps of a line along the longer side of a picture
_MEASURED_STEPS = 8.0  # distance over which a line is measured


def line_step_px(size: tuple[int, int]) -> int:
    """Return the unit of lengths along the lines of a layer of `size`, in pixels."""
    return math.ceil(max(size) / _LINE_STEPS)


@dataclass(frozen=True)
class Steadiness:
    """The memory for how steady rows and columns are, in nodes: R each.

    A row has a node for each `LINE_NODE` pixels across, a column for as many down.
    """

    rows: Texture
    columns: Texture

    @staticmethod
    def sizes(size: tuple[int, int]) -> tuple[tuple[int, int], tuple[int, int]]:
        """Return the sizes of both textures for a layer of `size`."""
        width, height = size
        return (groups_for(width, LINE_NODE), height), (width, groups_for(height, LINE_NODE))

    @property
    def textures(self) -> dict[str, Texture]:
        """The textures by their names in the fill of hidden pixels."""
        return {"rows_steadiness_tx": self.rows, "columns_steadiness_tx": self.columns}


# Recursive sums of all pixels along a line, in place of samples behind the two ends of each hidden
# pixel, which changed from pixel to pixel: hidden bars had rims ragged by 2 to 4 px. Nodes cost a
# quarter of a solution for every second pixel and measure as well.
class SteadinessPass:
    """Measures rows and columns by the variance of all that is visible of them."""

    _SYSTEM = LineSystem("lib/steadiness_system.lib.glsl")

    def __init__(self, solver: LineSolver) -> None:
        self._solver = solver

    def steps(
        self,
        color: Texture,
        size: tuple[int, int],
        visible_bits: StorageBuffer,
        out: Steadiness,
    ) -> Iterator[None]:
        """Write to `out` the logarithms of the weights of lines of a layer of `size`.

        `color` and `visible_bits` are those of the layer. The steps are short.
        """
        measured_nodes = _MEASURED_STEPS * line_step_px(size) / LINE_NODE
        axes: tuple[tuple[Axis, Texture], ...] = ("rows", out.rows), ("columns", out.columns)
        for (axis, image), nodes in zip(axes, out.sizes(size), strict=True):
            bindings = Bindings(
                {"layer_tx": color},
                {"out_steadiness_img": image},
                {"kappa": measured_nodes**2, "layer_size": size},
                {"bits_block": visible_bits},
            )
            yield from self._solver.steps(self._SYSTEM, axis, nodes, bindings)

"""A picture cut into bands of rows, so that drawing it can stop between any two of them."""

import moderngl

from heatlens.gpu.context import is_software
from heatlens.model.boxes import Box

# On a processor a hundred thousand pixels of a scene take about 10 ms. Each band processes all
# triangles again, each for half as long as a pixel, so that many of them call for larger bands.
_LEAST_PX = 1 << 17
_PX_FOR_A_TRIANGLE = 1
_ROWS = 64  # the side of a tile of Mesa's rasteriser


class Bands:
    """Divides a picture into bands by the cost of drawing on this machine."""

    def __init__(self, ctx: moderngl.Context, triangles: int) -> None:
        """Set `triangles`, the number that each band draws again."""
        self._pixels = max(_LEAST_PX, _PX_FOR_A_TRIANGLE * triangles) if is_software(ctx) else None

    def of(self, size: tuple[int, int]) -> list[Box]:
        """Return bands of whole rows that cover a picture of `size`; a GPU gets it all at once."""
        width, height = size
        if self._pixels is None:
            return [Box(0, 0, width, height)]
        rows = -(-self._pixels // (width * _ROWS)) * _ROWS
        return [Box(0, y, width, min(y + rows, height)) for y in range(0, height, rows)]

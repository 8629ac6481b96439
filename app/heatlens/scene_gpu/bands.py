"""A picture cut into bands of rows, so that drawing it can stop between any two of them."""

from dataclasses import replace

import moderngl

from heatlens.gpu.context import is_software
from heatlens.model.boxes import Box
from heatlens.scene.scene_view import SceneView

# On a processor so many pixels of a scene take about 100 ms of one core. Each band processes all
# triangles again, each for half as long as a pixel, so that many of them call for larger bands.
_LEAST_PX = 1 << 18
_PX_FOR_A_TRIANGLE = 1
_ROWS = 64  # the side of a tile of Mesa's rasteriser
_SAMPLES_MOST = 1 << 21  # of a band of samples, whose texture has 16 bytes for each

Rows = tuple[int, int]  # the first, and the one behind the last


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

    def of_samples(self, size: tuple[int, int], across: int, larger: int) -> list[Rows]:
        """Return the rows of bands of a picture with `across` x `across` samples a pixel.

        All of them have as many rows, so that the last one may end outside the picture. Those on a
        processor are `larger` times as large as others.
        """
        width, height = size
        most = _SAMPLES_MOST if self._pixels is None else min(larger * self._pixels, _SAMPLES_MOST)
        count = -(-height // max(1, most // (width * across * across)))
        rows = -(-height // count)
        return [(first, first + rows) for first in range(0, height, rows)]


def samples_of(view: SceneView, rows: Rows, across: int) -> SceneView:
    """Return the view of some rows of a picture with `across` x `across` samples a pixel.

    Its pixels are the samples.
    """
    (width, height), (first, end) = view.size, rows
    below_px = (first + end - height) / 2
    return replace(
        view,
        size=(across * width, across * (end - first)),
        focal_px=across * view.focal_px,
        jitter_px=(0.0, across * below_px),
        sample=0,
        across=across,
        first_row=first,
    )

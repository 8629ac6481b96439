"""Divide a picture into bands of rows, so that drawing can pause between two bands."""

from collections.abc import Iterator
from dataclasses import replace

import moderngl

from heatlens.gpu.context import is_software
from heatlens.model.boxes import Box
from heatlens.scene.scene_view import SceneView

# On a processor, this many pixels of a scene take about 25 ms of one core. Each band processes all
# triangles again, and a triangle takes half as long as a pixel, so many triangles need larger
# bands.
_LEAST_PX = 1 << 16
_PX_FOR_A_TRIANGLE = 1
_ROWS = 16  # a quarter of a tile of Mesa's rasteriser; also the least height of a band
_SAMPLES_MOST = 1 << 21  # samples in a band; its texture has 16 bytes for each

Rows = tuple[int, int]  # the first row, and the one after the last


class Bands:
    """Divides a picture into bands by the cost of drawing on this machine."""

    def __init__(self, ctx: moderngl.Context, triangles: int) -> None:
        """Create it; each band draws all `triangles` again.

        `share`, 1 at most, makes the bands on a processor smaller; it may change at any time.
        """
        self._is_cut, self._triangles, self.share = is_software(ctx), triangles, 1.0

    @property
    def _pixels(self) -> int:
        """The size of a band on a processor."""
        return max(round(self.share * _LEAST_PX), _PX_FOR_A_TRIANGLE * self._triangles)

    def of(self, size: tuple[int, int]) -> Iterator[Box]:
        """Yield bands of whole rows that cover a picture of `size`; for a GPU, a single band."""
        (width, height), y = size, 0
        while y < height:
            rows = -(-self._pixels // (width * _ROWS)) * _ROWS if self._is_cut else height
            yield Box(0, y, width, min(y + rows, height))
            y += rows

    def of_samples(self, size: tuple[int, int], across: int, larger: int) -> Iterator[Rows]:
        """Yield the rows of bands of a picture with `across` x `across` samples a pixel.

        All bands have the same number of rows, so that the last one may end outside the picture.
        On a processor they are `larger` times as large as usual.
        """
        (width, height), first = size, 0
        while first < height:
            most = min(larger * self._pixels, _SAMPLES_MOST) if self._is_cut else _SAMPLES_MOST
            count = -(-height // max(1, most // (width * across * across)))
            rows = -(-height // count)
            yield first, first + rows
            first += rows


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

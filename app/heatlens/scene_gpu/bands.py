"""A picture cut into bands of rows, so that drawing it can stop between any two of them."""

from collections.abc import Iterator
from dataclasses import replace

import moderngl

from heatlens.gpu.context import is_software
from heatlens.model.boxes import Box
from heatlens.scene.scene_view import SceneView

# On a processor so many pixels of a scene take about 25 ms of one core. Each band processes all
# triangles again, each for half as long as a pixel, so that many of them call for larger bands.
_LEAST_PX = 1 << 16
_PX_FOR_A_TRIANGLE = 1
_ROWS = 16  # a quarter of a tile of Mesa's rasteriser, which is also how low a share may go
_SAMPLES_MOST = 1 << 21  # of a band of samples, whose texture has 16 bytes for each

Rows = tuple[int, int]  # the first, and the one behind the last


class Bands:
    """Divides a picture into bands by the cost of drawing on this machine."""

    def __init__(self, ctx: moderngl.Context, triangles: int) -> None:
        """Set `triangles`, the number that each band draws again.

        `share`, 1 at most, makes the bands on a processor smaller; it may change at any time.
        """
        self._is_cut, self._triangles, self.share = is_software(ctx), triangles, 1.0

    @property
    def _pixels(self) -> int:
        """The size of a band on a processor."""
        return max(round(self.share * _LEAST_PX), _PX_FOR_A_TRIANGLE * self._triangles)

    def of(self, size: tuple[int, int]) -> Iterator[Box]:
        """Yield bands of whole rows that cover a picture of `size`; a GPU gets it all at once."""
        (width, height), y = size, 0
        while y < height:
            rows = -(-self._pixels // (width * _ROWS)) * _ROWS if self._is_cut else height
            yield Box(0, y, width, min(y + rows, height))
            y += rows

    def of_samples(self, size: tuple[int, int], across: int, larger: int) -> Iterator[Rows]:
        """Yield the rows of bands of a picture with `across` x `across` samples a pixel.

        All bands have the same number of rows, so that the last one may end outside the picture.
        Those on a processor are `larger` times as large as others.
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

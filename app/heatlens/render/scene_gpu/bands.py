"""Divide a picture into bands of rows, so that drawing can pause between two bands.

The picture never depends on the speed of a machine. A view of other rows would be rounded
differently: bands with views of their own are the same on every machine, and shorter steps draw
parts of such a band.
"""

from collections.abc import Iterator
from dataclasses import replace

from heatlens.core.model.boxes import Box
from heatlens.media.scene.scene_view import SceneView
from heatlens.render.gpu.context import is_software
from heatlens.render.gpu.device import Device

# On a processor, this many pixels of a scene take about 25 ms of one core. Each band processes all
# triangles again, and a triangle takes half as long as a pixel, so many triangles need larger
# bands.
_LEAST_PX = 1 << 16
_PX_PER_TRIANGLE = 1
# Rows come in quarters of a tile of Mesa's rasterizer; with a small share, in its smallest blocks.
_ROWS, _ROWS_LEAST = 16, 4
_SAMPLES_MOST = 1 << 21  # samples in a band; its texture has 16 bytes for each

Rows = tuple[int, int]  # the first row, and the one after the last


class Bands:
    """Divides a picture into bands by the cost of drawing on this machine."""

    def __init__(self, ctx: Device, triangles: int) -> None:
        """Make bands for a scene of so many `triangles`, all of which each band draws again.

        The attribute `share`, 1 at most, makes the bands of `of` smaller on a processor; it may
        change at any time. `are_small` is False on a GPU, where bands have the largest size.
        """
        self.are_small, self._triangles, self.share = is_software(ctx), triangles, 1.0

    def _band_pixels(self, share: float) -> int:
        """Return how many pixels a band has on a processor; `share` is that of the usual size."""
        return max(round(share * _LEAST_PX), _PX_PER_TRIANGLE * self._triangles)

    def of(self, size: tuple[int, int], factor: int = 1) -> Iterator[Box]:
        """Yield bands of whole rows that cover a picture of `size`; for a GPU, a single band.

        On a processor they are `factor` times as large as usual.
        """
        (width, height), y = size, 0
        while y < height:
            pixels = factor * self._band_pixels(self.share)
            step = max(_ROWS_LEAST, round(self.share * _ROWS))
            rows = -(-pixels // (width * step)) * step if self.are_small else height
            yield Box(0, y, width, min(y + rows, height))
            y += rows

    # These rows do not depend on `share`. When they did, the last digits of a picture depended on
    # the load: a worker and a window that drew the same frame differed in 330 or 768 of 614,400
    # values, in 7 of 12 runs.
    def of_samples(self, size: tuple[int, int], across: int, factor: int) -> Iterator[Rows]:
        """Yield the rows of bands of a picture with `across` x `across` samples a pixel.

        All bands have the same number of rows, so that the last one may end outside the picture.
        On a processor they are `factor` times as large as usual. With a share of 1, `of` does not
        divide the samples of a band.
        """
        width, height = size
        samples_max = (
            min(factor * self._band_pixels(1.0), _SAMPLES_MOST) if self.are_small else _SAMPLES_MOST
        )
        count = -(-height // max(1, samples_max // (width * across * across)))
        rows = -(-height // count)
        for first_row in range(0, height, rows):
            yield first_row, first_row + rows


def view_of_samples(view: SceneView, rows: Rows, across: int) -> SceneView:
    """Return the view of some rows of a picture with `across` x `across` samples a pixel.

    Its pixels are the samples.
    """
    (width, height), (first, end) = view.size, rows
    # how far the middle of these rows is below the middle of the picture
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

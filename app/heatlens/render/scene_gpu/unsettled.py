"""Find where a picture needs more samples, so that little else is drawn again.

A mask hides the other pixels from a draw, but a processor spends a fifth of the time of a drawn
sample on a hidden one.
"""

import numpy as np

from heatlens.render.gpu.resources import Texture
from heatlens.render.scene_gpu.bands import Rows

_GAP_PX = 64  # columns without an unsettled pixel that are worth another draw


class UnsettledPixels:
    """The pixels that need more samples.

    done  R, half float, 0 in these pixels
    """

    def __init__(self, done: Texture, is_read: bool) -> None:
        """Read `done` back if `is_read`, as is worth while on a processor."""
        self.done = done
        values = np.frombuffer(done.read(), np.float16) if is_read else np.zeros(1, np.float16)
        self._is_unsettled = (values == 0).reshape(done.size[::-1] if is_read else (1, 1))

    def runs(self, rows: Rows) -> list[tuple[int, int]]:
        """Return runs of columns that hold all unsettled pixels of some rows of the picture.

        A run is its first column and the one after its last.
        """
        if self._is_unsettled.size == 1:
            return [(0, self.done.width)]
        columns = np.flatnonzero(self._is_unsettled[slice(*rows)].any(axis=0))
        gaps = np.flatnonzero(np.diff(columns) > _GAP_PX) + 1
        runs = np.split(columns, gaps) if len(columns) else []
        return [(int(run[0]), int(run[-1]) + 1) for run in runs]

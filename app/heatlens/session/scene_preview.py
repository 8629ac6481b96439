"""The scene's pinhole picture in the window: small while something moves, whole when it rests."""

import math
import time
from collections.abc import Callable
from dataclasses import replace

from heatlens.defocus.pipeline import Steps
from heatlens.model.framing import Framing
from heatlens.model.shot import Shot
from heatlens.render import FrameRenderer
from heatlens.scene_gpu.scene_renderer import PINHOLE_VIEWS
from heatlens.source.pinhole import Pinhole

_REST_S = 0.08  # so long without a move is rest
_BUDGET_S = 0.03  # for drawing while something moves
_SCALES = (1.0, 1 / 2, 1 / 4)
_MORE_VIEWS_S = 0.006  # for views beyond the first while something moves
_GOOD_VIEWS = 16  # so many are worth a blur before all of them are there,
_ALL_AT_ONCE_S = 0.25  # unless all take no longer than this


class ScenePreview:
    """Chooses how large the scene is drawn, by how long it took before.

    While something moves: as large as the time allows, by one view or, where a machine has time
    left for more, by as many as there is time for. At rest, in slices: as large as it is asked for,
    then antialiased, soon well enough to be worth a blur, and whole at last.
    """

    def __init__(
        self, renderer: FrameRenderer, clock: Callable[[], float] = time.perf_counter
    ) -> None:
        self._renderer = renderer
        self._clock = clock
        self.begin()

    def begin(self) -> None:
        """Forget what was known: another scene is open."""
        self._asked: object = None
        self._wish: tuple[Shot, int] | None = None
        self._moved_at = -_REST_S
        self._scale = 1.0
        self._seconds_per_px = 0.0  # of a view
        self._coming: Steps[None] | None = None
        self._views = 0  # in what is seen, and
        self._coming_views = 0  # in what is coming

    @property
    def is_good(self) -> bool:
        """Return True where the picture is antialiased, if not as well as it will be."""
        return self._scale == 1.0 and self._views >= _GOOD_VIEWS

    @property
    def is_whole(self) -> bool:
        """Return True where the picture is as it is drawn for a file."""
        return self._scale == 1.0 and self._views >= PINHOLE_VIEWS

    def seen(self, shot: Shot) -> Shot:
        """Return the shot as it is drawn now: perhaps smaller."""
        framing = shot.framing or Framing()
        width, height = (max(1, round(side * self._scale)) for side in framing.size)
        return replace(shot, framing=replace(framing, width_px=width, height_px=height))

    def look(self, shot: Shot, frame: int, is_held: bool = False) -> Pinhole:
        """Draw the pinhole picture at the frame, as well as the time allows.

        `is_held`: it will move again soon, however long it rests now.
        """
        lens, self._wish = shot.lens_at(frame), (shot, frame)
        asked = (shot.framing, frame, lens.focal_length_mm, lens.sensor_width_mm)
        has_moved = is_held or (asked != self._asked and self._asked is not None)
        if asked != self._asked:
            self._coming, scale = None, self._scale_now(shot)
            self._drawn(shot, frame, scale, self._views_now(shot) if scale == 1.0 else 1)
            self._asked = asked  # a drawing that failed is tried again, and says why again
        if has_moved:
            self._moved_at = self._clock()  # rest begins when that is seen
        return self._renderer.loaded

    def refine(self, slice_s: float) -> None:
        """Go on with a better picture of what was last looked at, if that rests."""
        if self._wish is None or self.is_whole or self.seconds_to_rest() > 0:
            return
        if self._coming is None:
            self._coming_views = self._next_views(self._wish[0])
            self._coming = self._renderer.looking(*self._wish, self._coming_views)
        start = self._clock()
        for _ in self._coming:
            if self._clock() - start >= slice_s:
                return
        self._scale, self._views, self._coming = 1.0, self._coming_views, None

    def _next_views(self, shot: Shot) -> int:
        is_soon = self._whole_s(shot) * PINHOLE_VIEWS <= _ALL_AT_ONCE_S
        if self._scale < 1.0:
            return 1
        return PINHOLE_VIEWS if self.is_good or is_soon else _GOOD_VIEWS

    def seconds_to_rest(self) -> float:
        """Return how long until the whole picture is drawn; 0 where it may be."""
        return max(0.0, self._moved_at + _REST_S - self._clock())

    def _drawn(self, shot: Shot, frame: int, scale: float, views: int) -> None:
        self._scale, self._views = scale, views
        seen, start = self.seen(shot), self._clock()
        width, height = (seen.framing or Framing()).size
        self._renderer.look(seen, frame, views=views)
        self._seconds_per_px = max(self._clock() - start, 1e-4) / (width * height * views)

    def _whole_s(self, shot: Shot) -> float:
        """Return the seconds for one view of full size."""
        width, height = (shot.framing or Framing()).size
        return self._seconds_per_px * width * height

    def _scale_now(self, shot: Shot) -> float:
        """Return the largest scale that fits the time; small while nothing is known."""
        whole_s = self._whole_s(shot)
        fitting = [scale for scale in _SCALES if 0 < whole_s * scale * scale <= _BUDGET_S]
        return fitting[0] if fitting else _SCALES[-1]

    def _views_now(self, shot: Shot) -> int:
        """Return how many views there is time for: a power of two, for those are even."""
        many = min(_MORE_VIEWS_S / self._whole_s(shot), float(_GOOD_VIEWS))
        return int(2 ** math.floor(math.log2(many))) if many >= 1 else 1

"""Draw the scene's pinhole picture: small while something moves, whole when it rests."""

import math
import time
from collections.abc import Callable
from dataclasses import replace

from heatlens.core.model.shot.framing import Framing
from heatlens.core.model.shot.shot import Shot
from heatlens.render.defocus.steps import Steps
from heatlens.render.frame_renderer import FrameRenderer
from heatlens.render.scene_gpu.pinhole_draw import PINHOLE_VIEWS
from heatlens.render.source.pinhole import Pinhole

# Longest time between two checks for input, and a time far below it.
MOST_S, QUICK_S = 0.03, 0.008
LEAST = 1 / 16  # least share of a usual step
_IN_A_ROW = 2  # slow steps before the share is halved: a single one may have built a program
_QUICK_IN_A_ROW = 32  # quick steps before the share is doubled


# Bands were once cut for an idle machine. On a processor, what was drawn between two looks for
# input came all at once whenever the driver's queue was emptied, and the window of the demo was
# deaf for 0.7 to 1.4 s again and again. Each step therefore waits for what it has drawn, and its
# measured time sets the length of the next. Shorter steps draw parts of the same views: when they
# drew views of other rows, the last digits of a picture depended on how busy the machine was.
class Pace:
    """The share of a usual step that fits between two checks for input."""

    def __init__(self) -> None:
        self.share = 1.0
        self._slow = self._quick = 0

    def took(self, seconds: float) -> None:
        """Note the time of a step: slow steps halve the share, many quick ones double it."""
        self._slow = self._slow + 1 if seconds > MOST_S else 0
        self._quick = self._quick + 1 if seconds < QUICK_S else 0
        if self._slow == _IN_A_ROW:
            self.share, self._slow = max(LEAST, self.share / 2), 0
        elif self._quick == _QUICK_IN_A_ROW:
            self.share, self._quick = min(1.0, self.share * 2), 0


_REST_S = 0.08  # without movement for this long, the input rests
_BUDGET_S = 0.03  # time for drawing while something moves
_SCALES = (1.0, 1 / 2, 1 / 4)
_MORE_VIEWS_S = 0.006  # time for antialiasing views beyond the first while something moves
_GOOD_VIEWS = 16  # this many views are good enough to be blurred before all are drawn ...
_ALL_AT_ONCE_S = 0.25  # ... unless all of them together take no longer than this


class ScenePreview:
    """Chooses the size at which the scene is drawn, from the time it took before.

    While something moves, the scene is drawn as large as the time allows, with more than one view
    for antialiasing if there is time. At rest it is drawn in slices: first at full size, then
    antialiased well enough to be blurred, and at last with all views.
    """

    def __init__(
        self, renderer: FrameRenderer, clock: Callable[[], float] = time.perf_counter
    ) -> None:
        self._renderer = renderer
        self._clock = clock
        self._asked: object = None
        self._wish: tuple[Shot, int] | None = None
        self._moved_at = -_REST_S
        self._scale = 1.0
        self._seconds_per_px = 0.0  # drawing time of one view
        self._coming: Steps[None] | None = None
        self._views = 0  # views in the shown picture
        self._coming_views = 0  # views in the picture in progress
        self._pace = Pace()

    @property
    def is_good(self) -> bool:
        """True if the picture is antialiased well enough to be blurred."""
        return self._scale == 1.0 and self._views >= _GOOD_VIEWS

    @property
    def is_whole(self) -> bool:
        """True if the picture has the quality of a file."""
        return self._scale == 1.0 and self._views >= PINHOLE_VIEWS

    def seen(self, shot: Shot) -> Shot:
        """Return the shot that is drawn now, which may be smaller."""
        return replace(shot, framing=(shot.framing or Framing()).scaled(self._scale))

    def look(self, shot: Shot, frame: int, is_held: bool = False) -> Pinhole:
        """Draw the pinhole picture at the frame, as well as time allows.

        `is_held` means that it will move again soon, so it does not count as resting.
        """
        lens, self._wish = shot.lens_at(frame), (shot, frame)
        looks_from = (shot.framing, frame, lens.focal_length_mm, lens.sensor_width_mm)
        has_moved = is_held or (looks_from != self._asked and self._asked is not None)
        if looks_from != self._asked:
            self._coming, scale = None, self._scale_now(shot)
            self._drawn(shot, frame, scale, self._views_now(shot) if scale == 1.0 else 1)
            self._asked = looks_from  # only now, so that a failed drawing is tried again
        if has_moved:
            self._moved_at = self._clock()  # the rest begins after the drawing
        return self._renderer.loaded

    def refine(self, slice_s: float) -> None:
        """Improve the latest picture for about `slice_s` seconds, if the input rests."""
        if self._wish is None or self.is_whole or self.seconds_to_rest() > 0:
            return
        if self._coming is None:
            self._coming_views = self._next_views(self._wish[0])
            self._coming = self._renderer.looking(*self._wish, self._coming_views)
        start = before = self._clock()
        for _ in self._coming:
            self._renderer.settle()
            now = self._clock()
            self._pace.took(now - before)
            self._renderer.pace(self._pace.share)
            before = now
            if now - start >= slice_s:
                return
        self._scale, self._views, self._coming = 1.0, self._coming_views, None

    # A pixel has 16 samples, and the other 48 only where these differ. The first 16 are good enough
    # for a quick blur; the whole one waits for all of them, because a film picture of 16 views was
    # made only to be made again of 64.
    def _next_views(self, shot: Shot) -> int:
        is_soon = self._whole_s(shot) * PINHOLE_VIEWS <= _ALL_AT_ONCE_S
        if self._scale < 1.0:
            return 1
        return PINHOLE_VIEWS if self.is_good or is_soon else _GOOD_VIEWS

    def seconds_to_rest(self) -> float:
        """Return the seconds until the whole picture may be drawn; 0 if it may be now."""
        return max(0.0, self._moved_at + _REST_S - self._clock())

    def _drawn(self, shot: Shot, frame: int, scale: float, views: int) -> None:
        self._scale, self._views = scale, views
        scaled, start = self.seen(shot), self._clock()
        width, height = (scaled.framing or Framing()).size
        self._renderer.look(scaled, frame, views=views)
        self._seconds_per_px = max(self._clock() - start, 1e-4) / (width * height * views)

    def _whole_s(self, shot: Shot) -> float:
        """Return the predicted seconds for one view at full size."""
        width, height = (shot.framing or Framing()).size
        return self._seconds_per_px * width * height

    def _scale_now(self, shot: Shot) -> float:
        """Return the largest scale that fits the time; a small one before the first timing."""
        whole_s = self._whole_s(shot)
        fitting = [scale for scale in _SCALES if 0 < whole_s * scale * scale <= _BUDGET_S]
        return fitting[0] if fitting else _SCALES[-1]

    def _views_now(self, shot: Shot) -> int:
        """Return how many views fit the time: a power of two, whose samples are evenly spread."""
        many = min(_MORE_VIEWS_S / self._whole_s(shot), float(_GOOD_VIEWS))
        return int(2 ** math.floor(math.log2(many))) if many >= 1 else 1

"""Draw the scene's pinhole picture: small while something moves, whole when it rests."""

import math
import time
from collections.abc import Callable
from dataclasses import replace

from heatlens.core.model.shot.framing import Framing
from heatlens.core.model.shot.shot import Shot
from heatlens.render.defocus.steps import Steps
from heatlens.render.frame_renderer import FrameRenderer
from heatlens.render.scene_gpu.pinhole_draw import FIRST_VIEWS, PINHOLE_VIEWS
from heatlens.render.source.pinhole import Pinhole

# Longest time between two checks for input, and the time below which a step counts as quick: twice
# as long a step is then not slow. Half of QUICK_S kept a machine that was busy once at short steps,
# and with half of both the whole picture of the demo took 1.2 s longer on two cores.
SLOW_S, QUICK_S = 0.06, 0.03
MIN_SHARE = 1 / 16  # smallest share of a usual step
_IN_A_ROW = 2  # slow steps before the share is halved: a single one may have built a program
_QUICK_IN_A_ROW = 32  # quick steps before the share is doubled


# Each step waits until its drawing is finished, and its measured time sets the length of the next.
# Without that, on a processor everything drawn between two checks for input was finished at once
# when the driver's queue was emptied, and the window of the demo took no input for 0.7 to 1.4 s
# again and again. Shorter steps draw parts of the same views: with views of other rows, the last
# digits of a picture would depend on how busy the machine is.
class Pace:
    """The share of a usual step that fits between two checks for input."""

    def __init__(self) -> None:
        self.share = 1.0
        self._slow = self._quick = 0

    def note_time(self, seconds: float) -> None:
        """Note the time of a step: slow steps halve the share, many quick ones double it."""
        self._slow = self._slow + 1 if seconds > SLOW_S else 0
        self._quick = self._quick + 1 if seconds < QUICK_S else 0
        if self._slow == _IN_A_ROW:
            self.share, self._slow = max(MIN_SHARE, self.share / 2), 0
        elif self._quick == _QUICK_IN_A_ROW:
            self.share, self._quick = min(1.0, self.share * 2), 0


_REST_S = 0.08  # without movement for this long, the input rests
_BUDGET_S = 0.03  # time for drawing while something moves
_SCALES = (1.0, 1 / 2, 1 / 4)
# The time for antialiasing views beyond the first while something moves, and how many at most.
_MORE_VIEWS_S, _MOVING_VIEWS_MOST = 0.006, 16
_GOOD_VIEWS = FIRST_VIEWS  # these are good enough to be blurred before all are drawn ...
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
        self._drawn_view_key: object = None
        self._request: tuple[Shot, int] | None = None
        self.budget_s, self.rest_s = _BUDGET_S, _REST_S
        self._moved_at = -_REST_S
        self._scale = 1.0
        self._seconds_per_px = 0.0  # drawing time of one view
        self._refinement: Steps[None] | None = None
        self._views = 0  # views in the shown picture
        self._refinement_views = 0  # views in the picture in progress
        self._pace = Pace()

    @property
    def is_good(self) -> bool:
        """True if the picture is antialiased well enough to be blurred."""
        return self._scale == 1.0 and self._views >= _GOOD_VIEWS

    @property
    def is_whole(self) -> bool:
        """True if the picture has the quality of a file."""
        return self._scale == 1.0 and self._views >= PINHOLE_VIEWS

    def drawn_shot(self, shot: Shot) -> Shot:
        """Return the shot that is drawn now, which may be smaller."""
        return replace(shot, framing=(shot.framing or Framing()).scaled(self._scale))

    def draw(self, shot: Shot, frame: int, is_moving: bool = False) -> Pinhole:
        """Draw the pinhole picture at the frame, as well as time allows.

        With `is_moving`, the scene will move again soon, so it does not count as resting.
        """
        lens, self._request = shot.lens_at(frame), (shot, frame)
        view_key = (shot.framing, frame, lens.focal_length_mm, lens.sensor_width_mm)
        has_moved = is_moving or (
            view_key != self._drawn_view_key and self._drawn_view_key is not None
        )
        if view_key != self._drawn_view_key:
            self._refinement, scale = None, self._fitting_scale(shot)
            self._draw_whole(shot, frame, scale, self._fitting_views(shot) if scale == 1.0 else 1)
            self._drawn_view_key = view_key  # only now, so that a failed drawing is tried again
        if has_moved:
            self._moved_at = self._clock()  # the rest begins after the drawing
        return self._renderer.loaded

    def refine(self, slice_s: float) -> None:
        """Improve the latest picture for about `slice_s` seconds, if the input rests."""
        if self._request is None or self.is_whole or self.seconds_to_rest() > 0:
            return
        if self._refinement is None:
            self._refinement_views = self._next_views(self._request[0])
            self._refinement = self._renderer.load_pinhole_steps(
                *self._request, self._refinement_views
            )
        start = last_time = self._clock()
        for _ in self._refinement:
            self._renderer.settle()
            time_now = self._clock()
            self._pace.note_time(time_now - last_time)
            self._renderer.set_step_size(self._pace.share)
            last_time = time_now
            if time_now - start >= slice_s:
                return
        self._scale, self._views, self._refinement = 1.0, self._refinement_views, None

    # A pixel has 4 samples, and 48 more only where these differ. The first 4 are good enough for a
    # quick blur, and are not drawn again for the rest. A stage of 16 samples took a quarter of the
    # time to the whole picture. The whole blur waits for all of them, because a film picture of
    # fewer would only be replaced.
    def _next_views(self, shot: Shot) -> int:
        """Return how many views the next picture of the refinement has."""
        is_soon = self._full_size_view_s(shot) * PINHOLE_VIEWS <= _ALL_AT_ONCE_S
        if self._scale < 1.0:
            return 1
        return PINHOLE_VIEWS if self.is_good or is_soon else _GOOD_VIEWS

    def seconds_to_rest(self) -> float:
        """Return the seconds until the whole picture may be drawn; 0 if it may be now."""
        return max(0.0, self._moved_at + self.rest_s - self._clock())

    def _draw_whole(self, shot: Shot, frame: int, scale: float, views: int) -> None:
        """Draw the picture at once at this scale, and measure the time of a pixel."""
        self._scale, self._views = scale, views
        scaled, start = self.drawn_shot(shot), self._clock()
        width, height = (scaled.framing or Framing()).size
        self._renderer.load_pinhole(scaled, frame, views=views)
        self._seconds_per_px = max(self._clock() - start, 1e-4) / (width * height * views)

    def _full_size_view_s(self, shot: Shot) -> float:
        """Return the predicted seconds for one view at full size."""
        width, height = (shot.framing or Framing()).size
        return self._seconds_per_px * width * height

    def _fitting_scale(self, shot: Shot) -> float:
        """Return the largest scale that fits the time; a small one before the first timing."""
        view_s = self._full_size_view_s(shot)
        fitting_scales = [scale for scale in _SCALES if 0 < view_s * scale * scale <= self.budget_s]
        return fitting_scales[0] if fitting_scales else _SCALES[-1]

    def _fitting_views(self, shot: Shot) -> int:
        """Return how many views fit the time: a power of two, whose samples are evenly spread."""
        view_count = min(_MORE_VIEWS_S / self._full_size_view_s(shot), float(_MOVING_VIEWS_MOST))
        return int(2 ** math.floor(math.log2(view_count))) if view_count >= 1 else 1

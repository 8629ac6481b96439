"""The scene's pinhole picture in the window: small while something moves, whole when it rests."""

import time
from collections.abc import Callable
from dataclasses import replace

from heatlens.model.framing import Framing
from heatlens.model.shot import Shot
from heatlens.render import FrameRenderer, LoadedPlate

_REST_S = 0.15  # so long without a move is rest
_BUDGET_S = 0.03  # for drawing while something moves
_SCALES = (1.0, 1 / 2, 1 / 4, 1 / 8)
_PASSES = 4  # of a whole pinhole picture; one will do while it moves


class SceneSight:
    """Chooses how large the scene is drawn, by how long it took before."""

    def __init__(
        self, renderer: FrameRenderer, clock: Callable[[], float] = time.perf_counter
    ) -> None:
        self._renderer = renderer
        self._clock = clock
        self._seconds_per_px = 0.0
        self._asked: object = None
        self._moved_at = -_REST_S
        self._scale = 1.0
        self._latest: LoadedPlate | None = None
        self.is_whole = False

    def begin(self) -> None:
        """Another scene: its first picture is whole."""
        self._asked, self._moved_at, self.is_whole = None, -_REST_S, False
        self._seconds_per_px, self._latest = 0.0, None

    def seen(self, shot: Shot) -> Shot:
        """The shot as it is drawn now: perhaps smaller."""
        framing = shot.framing or Framing()
        width, height = (max(1, round(side * self._scale)) for side in framing.size)
        return replace(shot, framing=replace(framing, width_px=width, height_px=height))

    def look(self, shot: Shot, frame: int) -> LoadedPlate:
        """The pinhole picture at the frame, as well as the time allows."""
        lens = shot.lens_at(frame)
        asked = (shot.framing, frame, lens.focal_length_mm, lens.sensor_width_mm)
        if asked != self._asked:
            if self._asked is not None:
                self._moved_at = self._clock()
            self._asked, self._scale, self.is_whole = asked, self._scale_now(shot), False
        elif not self.is_whole and self.seconds_to_rest() <= 0:
            self._scale = 1.0
        return self._drawn(shot, frame)

    def seconds_to_rest(self) -> float:
        """How long until the whole picture is drawn; 0 where it may be."""
        return max(0.0, self._moved_at + _REST_S - self._clock())

    def _drawn(self, shot: Shot, frame: int) -> LoadedPlate:
        is_moving = self.seconds_to_rest() > 0
        seen, start = self.seen(shot), self._clock()
        loaded = self._renderer.look(seen, frame, passes=1 if is_moving else _PASSES)
        is_new, self._latest = loaded is not self._latest, loaded
        if is_moving and is_new:  # one that was there already tells nothing of the time
            framing = seen.framing or Framing()
            seconds = self._clock() - start
            self._seconds_per_px = max(seconds, 1e-4) / (framing.width_px * framing.height_px)
        self.is_whole = not is_moving and self._scale == 1.0
        return loaded

    def _scale_now(self, shot: Shot) -> float:
        """The largest at which a picture fits the time; small at first, for nothing is known."""
        if self.seconds_to_rest() <= 0:
            return 1.0
        if not self._seconds_per_px:
            return _SCALES[2]
        width, height = (shot.framing or Framing()).size
        whole_s = self._seconds_per_px * width * height
        fitting = [scale for scale in _SCALES if whole_s * scale * scale <= _BUDGET_S]
        return fitting[0] if fitting else _SCALES[-1]

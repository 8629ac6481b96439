"""Frames along a line of the screen: which part of them is seen, and where each one lies."""

import math
from dataclasses import dataclass, replace

_FRAMES_LEAST = 4.0  # seen at least, however near one looks
_STEPS = 1, 2, 5  # times a power of ten: from one number on the ruler to the next


@dataclass(frozen=True)
class TimeScale:
    """Frames `first` to `last` over `width` screen units from `x` on; each frame has a cell.

    `first` and `last` are times, so that the middle of the cell of frame n lies at n.
    """

    first: float
    last: float
    x: float
    width: float

    @classmethod
    def over(cls, first: float, last: float, x: float, width: float) -> "TimeScale":
        """Return a scale of the whole cells of the frames first to last."""
        return cls(first - 0.5, last + 0.5, x, max(width, 1.0))

    @property
    def per_frame(self) -> float:
        """Screen units a frame."""
        return self.width / (self.last - self.first)

    def x_at(self, frame: float) -> float:
        """Return where a time lies."""
        return self.x + (frame - self.first) * self.per_frame

    def time_at(self, x: float) -> float:
        """Return the time that lies there, between two frames as well."""
        return self.first + (x - self.x) / self.per_frame

    def frame_at(self, x: float) -> int:
        """Return the frame in whose cell `x` lies."""
        return math.floor(self.time_at(x) + 0.5)

    def words_x(self, frame: float, width: float) -> float:
        """Return where words of this width begin: under their frame, but never beyond the ends."""
        at = self.x_at(frame) - width / 2
        return max(min(at, self.x + self.width - width), self.x)

    def zoomed(self, factor: float, about_x: float, least: float, most: float) -> "TimeScale":
        """Return the scale zoomed about the time at `about_x`, within `least` to `most`."""
        here = self.time_at(about_x)
        frames = (self.last - self.first) / factor
        frames = min(max(frames, _FRAMES_LEAST), most - least)
        first = here - (here - self.first) * frames / (self.last - self.first)
        return replace(self, first=first, last=first + frames)._within(least, most)

    def panned(self, by_x: float, least: float, most: float) -> "TimeScale":
        """Return the scale moved along by so many screen units."""
        by = -by_x / self.per_frame
        return replace(self, first=self.first + by, last=self.last + by)._within(least, most)

    def _within(self, least: float, most: float) -> "TimeScale":
        frames = self.last - self.first
        first = min(max(self.first, least), max(most - frames, least))
        return replace(self, first=first, last=first + frames)

    def ticks(self, least_apart: float) -> range:
        """Return the frames with a number, so many screen units apart or more."""
        step = next(
            s * 10**power
            for power in range(10)
            for s in _STEPS
            if s * 10**power * self.per_frame >= least_apart or power == 9
        )
        return range(math.ceil(self.first / step) * step, math.floor(self.last) + 1, step)

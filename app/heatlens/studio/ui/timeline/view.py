"""Keep the state of the timeline panel between frames of the window.

`TimeScale` maps frames to screen positions: visible range, zoom, pan and ruler numbers.
"""

import math
from dataclasses import dataclass, field, replace

from heatlens.studio.session.keys.key_drag import KeyDrag, KeyStretch
from heatlens.studio.session.time.focus_track import FocusTrack
from heatlens.studio.ui.timeline.curve_axis import CurveLine

_FRAMES_LEAST = 4.0  # smallest visible number of frames
_STEPS = 1, 2, 5  # times a power of ten: frames between two numbers on the ruler


@dataclass(frozen=True)
class TimeScale:
    """Frames `first` to `last` over `width` screen units from `x` on; each frame has a cell.

    `first` and `last` are times: the cell of frame n is centred at time n.
    """

    first: float
    last: float
    x: float
    width: float

    @classmethod
    def over(cls, first: float, last: float, x: float, width: float) -> "TimeScale":
        """Return a scale that shows the whole cells of the frames first to last."""
        return cls(first - 0.5, last + 0.5, x, max(width, 1.0))

    @property
    def per_frame(self) -> float:
        """Screen units per frame."""
        return self.width / (self.last - self.first)

    def x_at(self, frame: float) -> float:
        """Return the x position of a time."""
        return self.x + (frame - self.first) * self.per_frame

    def time_at(self, x: float) -> float:
        """Return the time at a position, which may lie between two frames."""
        return self.first + (x - self.x) / self.per_frame

    def frame_at(self, x: float) -> int:
        """Return the frame in whose cell `x` lies."""
        return math.floor(self.time_at(x) + 0.5)

    def words_x(self, frame: float, width: float) -> float:
        """Return the x at which a text of `width` begins: centred on its frame if it fits."""
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
        """Return the scale moved by so many screen units."""
        by = -by_x / self.per_frame
        return replace(self, first=self.first + by, last=self.last + by)._within(least, most)

    def _within(self, least: float, most: float) -> "TimeScale":
        frames = self.last - self.first
        first = min(max(self.first, least), max(most - frames, least))
        return replace(self, first=first, last=first + frames)

    def ticks(self, least_apart: float) -> range:
        """Return the frames that get a number, at least `least_apart` screen units apart."""
        step = next(
            s * 10**power
            for power in range(10)
            for s in _STEPS
            if s * 10**power * self.per_frame >= least_apart or power == 9
        )
        return range(math.ceil(self.first / step) * step, math.floor(self.last) + 1, step)


@dataclass
class TimelineView:
    """The state of the timeline panel.

    drag          the drag of keys with the mouse
    stretch       the drag of one end of the chosen keys
    scale         the visible frames; None for all
    heights       the visible range of the curve, as places; None to fit the curve
    zoomed        the range that the user zoomed to; None to fit keys
    frames_all    fit marks too, not only keys
    pointed_at    the curve is under the pointer
    height_before the height of the panel before the curve was shown; None without a curve
    line          the points of the curve
    track         the depth of field along the shot, and the frames that are too close
    opens_frames  open the popup about rendered frames in the next frame
    """

    drag: KeyDrag
    stretch: KeyStretch
    scale: TimeScale | None = None
    heights: tuple[float, float] | None = None
    line: CurveLine = field(default_factory=CurveLine)
    track: FocusTrack = field(default_factory=FocusTrack)
    opens_frames: bool = False
    zoomed: tuple[float, float] | None = None
    frames_all: bool = False
    pointed_at: bool = False
    height_before: float | None = None

    def frame_all(self) -> None:
        """Fit keys and marks into the curve editor; a second time, only the keys."""
        self.frames_all = self.zoomed is not None or not self.frames_all
        self.zoomed = None

    def open_frames(self) -> None:
        """Open the popup about rendered frames in the next frame."""
        self.opens_frames = True

"""Keep the state of the timeline panel between frames of the window.

`TimeScale` maps frames to screen positions: visible range, zoom, pan and ruler numbers.
"""

import math
from dataclasses import dataclass, field, replace

from heatlens.core.model.shot.focus_track import FocusTrack
from heatlens.studio.board.key_drag import KeyDrag, KeyStretch
from heatlens.studio.ui.timeline.curve_axis import CurveLine

_MIN_FRAMES = 4.0  # smallest visible number of frames
_STEPS = 1, 2, 5  # times a power of ten: frames between two numbers on the ruler


@dataclass(frozen=True)
class TimeScale:
    """Frames `first` to `last` over `width` screen units from `x` on; each frame has a cell.

    `first` and `last` are times: the cell of frame n is centered at time n.
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
    def px_per_frame(self) -> float:
        """The width of one frame in screen units."""
        return self.width / (self.last - self.first)

    def x_at(self, frame: float) -> float:
        """Return the x position of a time on the screen; `frame` may lie between two frames."""
        return self.x + (frame - self.first) * self.px_per_frame

    def time_at(self, x: float) -> float:
        """Return the time at a position, which may lie between two frames."""
        return self.first + (x - self.x) / self.px_per_frame

    def frame_at(self, x: float) -> int:
        """Return the frame in whose cell `x` lies."""
        return math.floor(self.time_at(x) + 0.5)

    def text_x(self, frame: float, width: float) -> float:
        """Return the x at which a text of `width` begins: centered on its frame if it fits."""
        centered_x = self.x_at(frame) - width / 2
        return max(min(centered_x, self.x + self.width - width), self.x)

    def zoom(
        self, factor: float, about_x: float, first_time: float, last_time: float
    ) -> "TimeScale":
        """Return the scale zoomed about the time at `about_x`, within these two times."""
        fixed_time = self.time_at(about_x)
        frames = (self.last - self.first) / factor
        frames = min(max(frames, _MIN_FRAMES), last_time - first_time)
        first = fixed_time - (fixed_time - self.first) * frames / (self.last - self.first)
        return replace(self, first=first, last=first + frames)._within(first_time, last_time)

    def pan(self, by_x: float, first_time: float, last_time: float) -> "TimeScale":
        """Return the scale moved by `by_x` screen units, within these two times."""
        frames_moved = -by_x / self.px_per_frame
        return replace(
            self, first=self.first + frames_moved, last=self.last + frames_moved
        )._within(first_time, last_time)

    def _within(self, first_time: float, last_time: float) -> "TimeScale":
        """Return the scale moved so that it lies within these two times."""
        frames = self.last - self.first
        first = min(max(self.first, first_time), max(last_time - frames, first_time))
        return replace(self, first=first, last=first + frames)

    def ticks(self, min_gap: float) -> range:
        """Return the frames that get a number, at least `min_gap` screen units apart."""
        step = next(
            factor * 10**power
            for power in range(10)
            for factor in _STEPS
            if factor * 10**power * self.px_per_frame >= min_gap or power == 9
        )
        return range(math.ceil(self.first / step) * step, math.floor(self.last) + 1, step)


@dataclass
class TimelineView:
    """The state of the timeline panel.

    drag          the drag of keys with the mouse
    stretch       the drag of one end of the chosen keys
    scale         the visible frames; None for all
    heights       the visible range of the curve, as levels; None to fit the curve
    zoom_range    the range that the user zoomed to; None to fit keys
    fits_marks    fit marks too, not only keys
    is_hovered    the curve is under the pointer
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
    zoom_range: tuple[float, float] | None = None
    fits_marks: bool = False
    is_hovered: bool = False
    height_before: float | None = None

    def toggle_fit(self) -> None:
        """Fit keys and marks into the curve editor; a second time, only the keys."""
        self.fits_marks = self.zoom_range is not None or not self.fits_marks
        self.zoom_range = None

    def open_frames_popup(self) -> None:
        """Open the popup about rendered frames in the next frame."""
        self.opens_frames = True

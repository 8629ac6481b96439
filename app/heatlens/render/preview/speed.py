"""Measure the frames of the window, and compute the time that is left for a picture."""

import math
from collections import deque
from dataclasses import dataclass, field

_AVERAGED_FRAMES = 30  # number of latest pictures and frames to average
_GPU_S = 0.012  # keeps up with a 60 Hz screen
# Time of a frame of the window with a software rasterizer, where the same processor draws the
# window too, and the least time for a picture. This gives more than twelve pictures a second, even
# if one takes somewhat longer than predicted.
_FRAME_SOFTWARE_S, _MIN_BUDGET_S = 0.068, 0.012
# Time of a frame while a ring is turned. The user watches the picture, and the network adds
# latency, so the answer comes sooner, with a coarser picture if necessary.
_FRAME_RING_S = 0.04
_MAX_BUDGETS = 2.0  # budgets that a picture may take before it continues between the frames
# Where a processor draws the window, a frame without the picture costs as much as it delays the
# picture, so that a picture may take as long as two such frames, but no longer than this.
_MAX_WINDOWS, _ANSWER_MOST_S = 2.0, 0.2
_NEWEST_WEIGHT = 0.2  # weight of the newest frame in a running mean


@dataclass
class Speed:
    """The times of the latest frames of the window."""

    frames_s: deque[float] = field(default_factory=lambda: deque(maxlen=_AVERAGED_FRAMES))
    drag_frames_s: deque[float] = field(default_factory=lambda: deque(maxlen=_AVERAGED_FRAMES))
    is_software: bool = False  # the window is drawn by a software rasterizer
    is_for_ring: bool = False  # a ring is being turned, which needs quicker pictures
    window_s: float = 0.02  # running mean of drawing a frame without rendering its picture
    has_window: bool = False  # a window shows the picture, so the user waits for it

    def note_frame(self, seconds: float, picture_s: float, is_dragging: bool) -> None:
        """Note a drawn frame of the window; `picture_s` of it was for a new picture, 0 for none."""
        self.frames_s.append(seconds)
        self.window_s += _NEWEST_WEIGHT * (seconds - picture_s - self.window_s)
        if is_dragging and picture_s > 0:
            self.drag_frames_s.append(seconds)

    def mean_ms(self) -> float | None:
        """Return the mean time of a window frame in ms; None before the first."""
        return 1e3 * sum(self.frames_s) / len(self.frames_s) if self.frames_s else None

    def pictures_per_second(self) -> float | None:
        """Return the rate of new pictures during drags; None before the first drag."""
        return len(self.drag_frames_s) / sum(self.drag_frames_s) if self.drag_frames_s else None

    @property
    def answer_s(self) -> float:
        """The longest time for a picture before input is handled again."""
        if not self.has_window:
            return math.inf
        of_window_s = min(_MAX_WINDOWS * self.window_s, _ANSWER_MOST_S) if self.is_software else 0.0
        return max(_MAX_BUDGETS * self.budget_s, of_window_s)

    @property
    def budget_s(self) -> float:
        """The time for a picture during a drag, besides the time for the rest of the window."""
        if not self.is_software:
            return _GPU_S
        frame_s = _FRAME_RING_S if self.is_for_ring else _FRAME_SOFTWARE_S
        return max(_MIN_BUDGET_S, frame_s - self.window_s)

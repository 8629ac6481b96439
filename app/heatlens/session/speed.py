"""How long frames of the window take, and how much time that leaves for a picture."""

from collections import deque
from dataclasses import dataclass, field

_KEPT = 30  # pictures and frames that the means are over
_GPU_S = 0.012  # keeps up with the screen
# A software rasteriser draws the window with the same processor: above twelve pictures a second,
# also where one takes somewhat longer than was expected.
_FRAME_SOFTWARE_S, _LEAST_S = 0.068, 0.012
# A ring is turned with the eyes on the picture, and its turns come over a network: they are
# answered sooner, by a coarser picture where it has to be.
_FRAME_RING_S = 0.04
_NEWEST = 0.2  # weight of the newest frame in a running mean


@dataclass
class Speed:
    """The times of the latest frames of the window."""

    frames_s: deque[float] = field(default_factory=lambda: deque(maxlen=_KEPT))
    held_s: deque[float] = field(default_factory=lambda: deque(maxlen=_KEPT))
    is_software: bool = False  # the processor draws the window as well
    is_for_ring: bool = False  # a ring is turned, which a quicker picture answers
    upload_s: float = 0.0  # of the latest plate
    window_s: float = 0.02  # running mean of drawing a frame without rendering its picture

    def frame(self, seconds: float, picture_s: float, is_held: bool) -> None:
        """Note that a frame was drawn, `picture_s` of it for a new picture, 0 where none was."""
        self.frames_s.append(seconds)
        self.window_s += _NEWEST * (seconds - picture_s - self.window_s)
        if is_held and picture_s > 0:
            self.held_s.append(seconds)

    def mean_ms(self) -> float | None:
        """Return the milliseconds for a frame of the window; None before the first."""
        return 1e3 * sum(self.frames_s) / len(self.frames_s) if self.frames_s else None

    def pictures_per_second(self) -> float | None:
        """Return the rate of new pictures while something was dragged; None before that."""
        return len(self.held_s) / sum(self.held_s) if self.held_s else None

    @property
    def budget_s(self) -> float:
        """Time for a picture while something is dragged, beside drawing the window without it."""
        if not self.is_software:
            return _GPU_S
        frame_s = _FRAME_RING_S if self.is_for_ring else _FRAME_SOFTWARE_S
        return max(_LEAST_S, frame_s - self.window_s)
